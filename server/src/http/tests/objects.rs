//! Movable objects over time, as a client sees them while a run goes on and after.

use super::*;
use crate::documents::testing::yard;

fn pushing(epochs: u32) -> Value {
    json!({
        "base": {
            "arena": yard(),
            "controller": { "method": "brownian" }, "engine": "rapier", "episodes": "continue",
            "robots": 4, "placement": "random", "epochs": epochs, "steps_per_epoch": 2_000,
        },
        "seeds": { "first": 1, "count": 1 },
    })
}

async fn objects(service: &Service, run: &str) -> api::ObjectTracks {
    let answer = service.get(&format!("{run}/objects")).await;
    assert_eq!(answer.status, 200);
    serde_json::from_slice(&answer.body).unwrap()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn objects_over_time_agree_with_the_result() {
    let service = Service::start(None);
    let job = service.job(&pushing(3)).await;
    service.wait_until(&job, "done").await;
    let run = &service.runs(&job).await[0];
    let run = format!("/v1/runs/{}", run["id"].as_str().unwrap());
    let told = objects(&service, &run).await;
    let result: api::RunResult =
        serde_json::from_slice(&service.get(&format!("{run}/result")).await.body).unwrap();
    let metrics: api::Metrics =
        serde_json::from_slice(&service.get(&format!("{run}/metrics")).await.body).unwrap();
    assert_eq!(told.objects.len(), 2);
    for (track, end) in told.objects.iter().zip(&result.objects) {
        assert_eq!(track.kind, end.kind);
        assert_eq!(track.samples.len(), 1 + metrics.rows.len());
        let last = track.samples.last().unwrap();
        assert_eq!(
            (last.steps, last.epoch, last.moved_m),
            (6_000, 3, end.moved_m)
        );
        assert!((last.time_s - 6_000.0 * 0.064).abs() < 1e-9);
        let place = [last.x_m, last.y_m].map(f64::from);
        assert_eq!(place, [end.x_m, end.y_m]);
        assert!((f64::from(last.heading_rad).sin() - end.sin).abs() < 1e-6);
        assert!(track.samples.is_sorted_by_key(|sample| sample.moved_m));
    }
    assert!(result.objects.iter().any(|object| object.moved_m > 0.01));
    let csv = service.get(&format!("{run}/objects.csv")).await;
    assert_eq!(csv.media_type(), "text/csv; charset=utf-8");
    let text = String::from_utf8(csv.body.to_vec()).unwrap();
    let mut lines = text.lines();
    assert_eq!(
        lines.next(),
        Some("steps,epoch,object,x_m,y_m,heading_rad,moved_m")
    );
    // In order of time, then of objects, and number by number what JSON has.
    for place in 0..=metrics.rows.len() {
        for (number, track) in told.objects.iter().enumerate() {
            let s = track.samples[place];
            let expected = format!(
                "{},{},{number},{:?},{:?},{:?},{:?}",
                s.steps, s.epoch, s.x_m, s.y_m, s.heading_rad, s.moved_m
            );
            assert_eq!(lines.next(), Some(expected.as_str()));
        }
    }
    assert_eq!(lines.next(), None);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn objects_are_told_of_while_a_run_goes_on() {
    let service = Service::start(None);
    let job = service.job(&pushing(1_000_000)).await;
    let run = &service.runs(&job).await[0];
    let run = format!("/v1/runs/{}", run["id"].as_str().unwrap());
    let start = Instant::now();
    let mut seen = 0;
    while seen == 0 {
        let told = objects(&service, &run).await;
        let samples = told.objects.iter().map(|track| &track.samples);
        seen = samples.flatten().filter(|sample| sample.steps > 0).count();
        assert!(start.elapsed() < Duration::from_secs(60));
    }
    // Stopped, it tells of its checkpoint.
    service.post(&format!("{job}/pause"), &json!({})).await;
    service.wait_until(&job, "paused").await;
    // The checkpoint is written just after the state.
    while objects(&service, &run).await.objects[0].samples.len() < 2 {
        assert!(start.elapsed() < Duration::from_secs(60));
    }
    service.post(&format!("{job}/cancel"), &json!({})).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_arena_without_objects_has_none() {
    let service = Service::start(None);
    let made = service.job(&job(1, 1)).await;
    service.wait_until(&made, "done").await;
    let run = &service.runs(&made).await[0];
    let run = format!("/v1/runs/{}", run["id"].as_str().unwrap());
    assert!(objects(&service, &run).await.objects.is_empty());
    let csv = service.get(&format!("{run}/objects.csv")).await;
    assert_eq!(
        &csv.body[..],
        b"steps,epoch,object,x_m,y_m,heading_rad,moved_m\n"
    );
}
