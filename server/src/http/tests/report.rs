//! Reports on jobs of the template `chapter-5`, and jobs that are tried again.

use super::*;

#[tokio::test]
async fn a_job_of_chapter_5_has_a_report() {
    let service = Service::start(None);
    let every_method = |epochs: u32| {
        json!({
            "base": { "epochs": epochs, "steps_per_epoch": 20, "arena": "easy" },
            "matrix": { "controller.method": crate::documents::CHAPTER_5_METHODS },
            "seeds": { "first": 1, "count": 1 }
        })
    };
    let long = service.job(&every_method(1_000_000)).await;
    assert_problem(&service.get(&format!("{long}/report.md")).await, 409);
    assert_eq!(service.ask("DELETE", &long).await.status, 204);

    let job = service.job(&every_method(2)).await;
    let path = format!("{job}/report");
    service.wait_until(&job, "done").await;
    let claims = service.get(&path).await.json();
    assert_eq!(claims["claims"].as_array().unwrap().len(), 10);
    for (suffix, media_type, start) in [
        ("html", "text/html; charset=utf-8", "<!doctype html>"),
        ("md", "text/markdown; charset=utf-8", "# Ev-ITER"),
        (
            "csv",
            "text/csv; charset=utf-8",
            "engine,arena,method,seed,p1",
        ),
    ] {
        let answer = service.get(&format!("{path}.{suffix}")).await;
        assert_eq!((answer.status, answer.media_type()), (200, media_type));
        let text = String::from_utf8_lossy(&answer.body).to_lowercase();
        assert!(text.starts_with(&start.to_lowercase()), "{}", &text[..80]);
    }
}

/// As is the template with a `base` beside it.
#[tokio::test]
async fn a_job_of_chapter_5_under_other_settings_has_a_report() {
    let service = Service::start(None);
    let job = service
        .job(&json!({
            "base": {
                "epochs": 2, "steps_per_epoch": 20, "arena": "easy",
                "controller": { "preset": "free" }, "robot": { "contact_friction": 0.75 }
            },
            "matrix": { "controller.method": crate::documents::CHAPTER_5_METHODS },
            "seeds": { "first": 1, "count": 1 }
        }))
        .await;
    service.wait_until(&job, "done").await;
    let answer = service.get(&format!("{job}/report.md")).await;
    assert_eq!(answer.status, 200);
    let text = String::from_utf8_lossy(&answer.body).into_owned();
    let settings = text.split_once("BASE.json, which").unwrap().1;
    assert!(
        settings.contains("\"contact_friction\": 0.75"),
        "{settings}"
    );
}

#[tokio::test]
async fn another_job_has_none() {
    let service = Service::start(None);
    let job = service.job(&job(1, 2)).await;
    service.wait_until(&job, "done").await;
    assert_problem(&service.get(&format!("{job}/report")).await, 404);
    assert_problem(&service.get("/v1/jobs/77/report.html").await, 404);
}

#[tokio::test]
async fn a_cancelled_job_can_be_tried_again() {
    let service = Service::start(None);
    let path = service.job(&job(2_000, 2)).await;
    let retry = format!("{path}/retry");
    assert_problem(&service.ask("POST", &retry).await, 409);
    service.ask("POST", &format!("{path}/cancel")).await;
    service.wait_until(&path, "cancelled").await;
    let again = service.ask("POST", &retry).await;
    assert_eq!(
        (again.status, &again.json()["runs"]["cancelled"]),
        (200, &json!(0))
    );
    let done = service.wait_until(&path, "done").await;
    assert_eq!(done["runs"]["done"], 2);
    assert_problem(&service.ask("POST", "/v1/jobs/77/retry").await, 404);
}
