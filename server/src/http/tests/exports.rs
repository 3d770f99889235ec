//! Tables of jobs over HTTP.

use api::ProblemCode;
use axum::http::HeaderName;
use axum::http::header::{
    ACCEPT_ENCODING, CONTENT_ENCODING, CONTENT_LENGTH, CONTENT_RANGE, IF_RANGE, RANGE,
};

use super::*;

/// Reads a table of texts; no cell of these tests needs quotes but labels.
fn csv(answer: &Answer) -> Vec<Vec<String>> {
    let text = String::from_utf8(answer.body.to_vec()).unwrap();
    let cells = |line: &str| line.split(',').map(str::to_owned).collect();
    text.lines().map(cells).collect()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_job_is_given_as_tables() {
    let service = Service::start(None);
    let mut body = job(3, 2);
    body["matrix"] = json!({ "controller.method": ["brownian", "im"] });
    let path = service.job(&body).await;
    service.wait_until(&path, "done").await;
    let table = service.get(&format!("{path}/runs.csv")).await;
    assert_eq!(
        (table.status, table.media_type()),
        (200, "text/csv; charset=utf-8")
    );
    let rows = csv(&table);
    let column = |name: &str| {
        let place = rows[0].iter().position(|column| column == name).unwrap();
        rows[1..].iter().map(move |row| row[place].clone())
    };
    assert!(column("method").eq(["brownian", "brownian", "im", "im"]));
    assert!(column("controller.method").eq(column("method")));
    assert!(column("seed").eq(["1", "2", "1", "2"]));
    assert!(column("steps_per_epoch").all(|cell| cell == "200"));
    let found = service.runs(&path).await;
    let p1: Vec<String> = found
        .iter()
        .map(|run| run["result"]["p1"].to_string())
        .collect();
    assert!(column("p1").eq(p1));

    // Compressed, it comes to its end too.
    let request = request("GET", &format!("{path}/runs.csv")).header(ACCEPT_ENCODING, "gzip");
    let compressed = service.send(request, Body::empty()).await;
    assert_eq!(compressed.headers[CONTENT_ENCODING], "gzip");
    assert!(compressed.body.len() < table.body.len() && !compressed.body.is_empty());

    for name in ["runs", "curves", "metrics"] {
        let table = service.get(&format!("{path}/{name}.parquet")).await;
        assert_eq!(
            (table.status, table.media_type()),
            (200, "application/vnd.apache.parquet")
        );
        assert!(table.body.starts_with(b"PAR1") && table.body.ends_with(b"PAR1"));
    }
    let run = format!("/v1/runs/{}", found[0]["id"].as_str().unwrap());
    let table = service.get(&format!("{run}/metrics.parquet")).await;
    assert!(table.body.starts_with(b"PAR1") && table.body.ends_with(b"PAR1"));
}

#[tokio::test]
async fn a_job_that_has_not_begun_has_empty_cells() {
    let service = Service::start(None);
    let path = service.job(&job(1_000_000, 2)).await;
    let rows = csv(&service.get(&format!("{path}/runs.csv")).await);
    assert_eq!(rows.len(), 3);
    let p1 = rows[0].iter().position(|column| column == "p1").unwrap();
    assert!(rows[1..].iter().all(|row| row[p1].is_empty()));
    let missing = service.get("/v1/jobs/77/runs.parquet").await;
    assert_problem(&missing, 404);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_reader_that_goes_away_ends_the_work_and_places_are_bounded() {
    let service = Service::start(None);
    let mut body = job(20_000, 8);
    body["base"]["steps_per_epoch"] = json!(1);
    let path = service.job(&body).await;
    service.wait_until(&path, "done").await;
    let open = || async {
        let request = request("GET", &format!("{path}/curves.parquet"));
        let request = request.body(Body::empty()).unwrap();
        service.routes.clone().oneshot(request).await.unwrap()
    };
    // Nobody reads, so none of them ends: their parts wait.
    let mut held = Vec::new();
    for _ in 0..4 {
        let answer = open().await;
        assert_eq!(answer.status(), 200);
        held.push(answer);
    }
    let refused = service.get(&format!("{path}/runs.csv")).await;
    assert_problem(&refused, ProblemCode::Overloaded.status());
    drop(held);
    let start = Instant::now();
    while service.get(&format!("{path}/runs.csv")).await.status != 200 {
        assert!(start.elapsed() < Duration::from_secs(20));
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn tables_and_checkpoints_have_tags_and_parts_once_they_stay_as_they_are() {
    let service = Service::start(None);
    let path = service.job(&job(4, 2)).await;
    service.wait_until(&path, "done").await;
    let runs = service.runs(&path).await;
    let run = format!("/v1/runs/{}", runs[1]["id"].as_str().unwrap());
    let ask = async |path: &str, headers: &[(HeaderName, &str)]| {
        let asked = (headers.iter()).fold(request("GET", path), |asked, (name, value)| {
            asked.header(name, *value)
        });
        service.send(asked, Body::empty()).await
    };
    let tables = [
        "runs.csv",
        "runs.parquet",
        "curves.parquet",
        "metrics.parquet",
    ];
    let tables = tables.map(|name| format!("{path}/{name}"));
    let checkpoint = format!("{run}/checkpoint");
    let mut tags = Vec::new();
    for path in tables.iter().chain([&checkpoint]) {
        let whole = service.get(path).await;
        assert_eq!(whole.status, 200, "{path}");
        let tag = whole.headers[ETAG].to_str().unwrap().to_owned();
        assert!(
            tag.starts_with('"') && !tags.contains(&tag),
            "{path}: {tag}"
        );
        assert_eq!(whole.headers["accept-ranges"], "bytes");
        let again = ask(path, &[(IF_NONE_MATCH, &tag)]).await;
        assert_eq!((again.status, again.body.len()), (304, 0), "{path}");
        assert_eq!(again.headers[ETAG], *tag);
        let length = whole.body.len();
        let end = length - 7;
        for (range, bytes) in [
            ("bytes=0-0".to_owned(), 0..1),
            ("bytes=5-99".to_owned(), 5..100),
            ("bytes=-7".to_owned(), end..length),
            (format!("bytes={end}-"), end..length),
        ] {
            let part = ask(path, &[(RANGE, &range), (IF_RANGE, &tag)]).await;
            assert_eq!(
                (part.status, &part.headers[ETAG]),
                (206, &whole.headers[ETAG]),
                "{path} {range}"
            );
            assert!(
                part.body == whole.body.slice(bytes.clone()),
                "{path} {range}"
            );
            let told = format!("bytes {}-{}/{length}", bytes.start, bytes.end - 1);
            assert_eq!(part.headers[CONTENT_RANGE], *told);
            assert_eq!(part.headers[CONTENT_LENGTH], *bytes.len().to_string());
        }
        let beyond = ask(path, &[(RANGE, &format!("bytes={length}-"))]).await;
        assert_refused(&beyond, "bytes beyond the end of a file (`Range`)");
        assert_eq!(beyond.headers[CONTENT_RANGE], *format!("bytes */{length}"));
        let other = ask(path, &[(RANGE, "bytes=0-0"), (IF_RANGE, "\"other\"")]).await;
        assert_eq!((other.status, &other.body), (200, &whole.body));
        tags.push(tag);
    }
    // Of another job, and after a run of it is gone, they are others.
    service.ask("DELETE", &run).await;
    for (path, tag) in tables.iter().zip(&tags) {
        let changed = ask(path, &[(IF_NONE_MATCH, tag)]).await;
        assert_eq!(changed.status, 200, "{path}");
        assert_ne!(changed.headers[ETAG], **tag);
    }
    // A job under way tells something else each time.
    let path = service.job(&job(1_000_000, 1)).await;
    let table = ask(&format!("{path}/runs.csv"), &[(RANGE, "bytes=0-0")]).await;
    assert_eq!(table.status, 200);
    assert!(!table.headers.contains_key(ETAG) && table.body.len() > 1);
}
