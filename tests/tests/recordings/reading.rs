//! A recording is read as slices and tables that say the same.

use api::recording::{RecordingSlice, RecordingState};
use serde_json::json;
use tests::server::Server;

#[test]
fn tables_hold_what_slices_show() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let mut spec = tests::small_spec();
    spec["robots"] = json!(2);
    spec["placement"] = json!("grid");
    spec["record"] = json!({ "every_steps": 50, "fields": ["pose", "command"] });
    let job = server.submit(&tests::job(spec, 1));
    server.wait_for(&job);
    let id = server.only_run(&job).id;
    let path = format!("/v1/runs/{id}/recording");
    let slice: RecordingSlice = server.read(&format!("{path}.json?robots=1"));
    // Three epochs, each with its beginning and four moments more.
    assert_eq!(slice.step[..6], [0, 50, 100, 150, 200, 200]);
    assert_eq!(slice.epoch_step[..6], [0, 50, 100, 150, 200, 0]);
    assert_eq!(slice.step.len(), 15);
    assert_eq!(slice.recording.state, RecordingState::Done);
    let csv = server.get(&format!("{path}.csv"));
    let mut lines = csv.text().lines();
    assert_eq!(
        lines.next().unwrap(),
        "step,time_s,epoch,epoch_step,phase,in_training,robot,x_m,y_m,heading_rad,left,right"
    );
    let of_robot = lines.filter(|line| line.split(',').nth(6) == Some("1"));
    let x_m: Vec<f64> = of_robot
        .map(|line| line.split(',').nth(7).unwrap().parse().unwrap())
        .collect();
    assert_eq!(x_m, slice.robots[0].poses.x_m);
    assert_eq!(server.get(&format!("{path}.parquet")).body[..4], *b"PAR1");
    let wrong = server.get(&format!("{path}.json?robots=7")).problem(400);
    assert_eq!(wrong.code, "invalid-query");
}
