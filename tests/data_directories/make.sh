#!/usr/bin/env bash
# Makes a small data directory with the program as it is now, and beside it what the program answers
# about it: jobs that are done, failed, cancelled, paused and under way (with a checkpoint).
#
# usage: make.sh PROGRAM DIR    (DIR must not exist; PROGRAM is a built evswarm)
set -euo pipefail
program=$(realpath "$1")
mkdir "$2"
dir=$(realpath "$2")
mkdir "$dir/expected"
port=${PORT:-18431}
url=http://127.0.0.1:$port
export XDG_RUNTIME_DIR="$dir"
unset EVSWARM_TOKEN

"$program" serve --listen "127.0.0.1:$port" --data "$dir/data" --threads 1 \
    --run-memory-bytes 2000000 2>"$dir/log" &
server=$!
trap 'kill -9 $server 2>/dev/null || true' EXIT
until curl -sf "$url/health/readyz" >/dev/null; do sleep 0.1; done

post() { curl -sf -H 'content-type: application/json' -d "$2" "$url/v1/$1"; }
settled() { # job, state
    until curl -sf "$url/v1/jobs/$1" | grep -q "\"state\":\"$2\""; do sleep 0.1; done
}

post arenas '{"name": "cell", "width_m": 0.6, "height_m": 0.6, "squares": 20,
    "walls_m": [[0.3, 0, 0.3, 0.35]],
    "starts": [{"x_m": 0.1, "y_m": 0.1, "heading_rad": 0.3}]}' >/dev/null
# 1: done; two methods, two seeds, swarm metrics
post jobs '{"name": "done", "base": {"arena": "cell", "epochs": 12, "steps_per_epoch": 200,
    "controller": {"babbling_epochs": 1}}, "matrix": {"controller.method": ["brownian", "im"]},
    "seeds": {"first": 1, "count": 2}}' >/dev/null
settled 1 done
# 2: done; movable objects, two robots, rapier
post jobs '{"name": "objects", "base": {"arena": {"name": "yard", "width_m": 0.8, "height_m": 0.6,
    "squares": 20, "walls_m": [],
    "starts": [{"x_m": 0.1, "y_m": 0.1, "heading_rad": 0.8}, {"x_m": 0.7, "y_m": 0.5, "heading_rad": 3.9}],
    "objects": [{"kind": "disc", "x_m": 0.4, "y_m": 0.3, "radius_m": 0.03, "mass_kg": 0.02}]},
    "controller": {"method": "brownian"}, "epochs": 3, "steps_per_epoch": 300, "robots": 2,
    "engine": "rapier", "episodes": "continue"}}' >/dev/null
settled 2 done
# 3: failed for its memory
post jobs '{"name": "failed", "base": {"arena": "cell", "epochs": 200, "steps_per_epoch": 2000,
    "controller": {"method": "im", "sample": 500000, "babbling_epochs": 200}}}' >/dev/null
settled 3 failed
# 4: under way when the server stops, with a checkpoint; 5: paused on the way; 6: cancelled
post jobs '{"name": "under way", "base": {"arena": "cell", "epochs": 20, "steps_per_epoch": 1000000,
    "controller": {"method": "im", "babbling_epochs": 1}}}' >/dev/null
settled 4 running
post jobs '{"name": "paused", "base": {"arena": "cell", "seed": 5, "epochs": 30, "steps_per_epoch": 200,
    "controller": {"method": "brownian"}}}' >/dev/null
curl -sf -X POST "$url/v1/jobs/5/pause" >/dev/null
post jobs '{"name": "cancelled", "base": {"arena": "cell", "seed": 6, "epochs": 30,
    "steps_per_epoch": 200, "controller": {"method": "brownian"}}}' >/dev/null
curl -sf -X POST "$url/v1/jobs/6/cancel" >/dev/null
until curl -sf "$url/v1/jobs/4/runs" | grep -q '"epochs_done":[1-9]'; do sleep 0.1; done
kill -TERM $server
wait $server || true

# What it answers, after a restart that goes on with nothing: the jobs under way are paused first.
"$program" serve --listen "127.0.0.1:$port" --data "$dir/data" --threads 1 2>>"$dir/log" &
server=$!
until curl -sf "$url/health/readyz" >/dev/null; do sleep 0.1; done
curl -sf -X POST "$url/v1/jobs/4/pause" >/dev/null
settled 4 paused
get() { curl -sf "$url/v1/$1" -o "$dir/expected/$2"; }
get jobs jobs.json
get arenas/cell arena.json
for job in 1 2 3 4 5 6; do
    get "jobs/$job" "job-$job.json"
    get "jobs/$job/runs" "job-$job-runs.json"
done
get jobs/1/summary.csv job-1-summary.csv
for job in 1 2; do
    for run in $(grep -o '"id":"[0-9a-f]*"' "$dir/expected/job-$job-runs.json" | cut -d'"' -f4); do
        for file in spec result curve.csv metrics.csv objects.csv robots.csv coverage.csv coverage.npy dwell.npy; do
            get "runs/$run/$file" "run-$run-$file"
        done
    done
done
run=$(grep -o '"id":"[0-9a-f]*"' "$dir/expected/job-4-runs.json" | cut -d'"' -f4)
for file in spec curve.csv coverage.csv; do get "runs/$run/$file" "run-$run-$file"; done
kill -TERM $server
wait $server || true

# What the run under way comes to: in a copy, so that DIR keeps it half done.
cp -a "$dir/data" "$dir/copy"
"$program" serve --listen "127.0.0.1:$port" --data "$dir/copy" --threads 1 2>>"$dir/log" &
server=$!
until curl -sf "$url/health/readyz" >/dev/null; do sleep 0.1; done
curl -sf -X POST "$url/v1/jobs/4/resume" >/dev/null
settled 4 done
get "runs/$run/result" "run-$run-result-when-done"
kill -TERM $server
wait $server || true
trap - EXIT
rm -rf "$dir/copy" "$dir/log" "$dir"/evswarm "$dir"/iceoryx2* "$dir/data/lock"
du -sh "$dir"
