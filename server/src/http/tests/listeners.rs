//! Listeners to all, to a job and to a run have their places in common.

use super::*;

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn all_listeners_share_one_limit() {
    let service = Service::start(None);
    let job = service.job(&job(1, 1)).await;
    let run = service.runs(&job).await[0]["id"].clone();
    let paths = [
        "/v1/events".to_owned(),
        format!("{job}/events"),
        format!("/v1/runs/{}/events", run.as_str().unwrap()),
    ];
    let mut open = Vec::new();
    for path in paths.iter().cycle().take(crate::events::MAX_LISTENERS) {
        let request = request("GET", path).body(Body::empty()).unwrap();
        let response = service.routes.clone().oneshot(request).await.unwrap();
        assert_eq!(response.status(), 200, "{path}");
        open.push(response);
    }
    for path in &paths {
        assert_problem(&service.get(path).await, 503);
    }
    // A place is free again when a listener has gone.
    open.pop();
    let request = request("GET", &paths[0]).body(Body::empty()).unwrap();
    let response = service.routes.clone().oneshot(request).await.unwrap();
    assert_eq!(response.status(), 200);
}
