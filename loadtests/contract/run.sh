#!/bin/sh
# The OpenAPI document against a real server: requests made of it at random, right and wrong ones;
# no answer that it does not have, and none of 5xx. Usage: run.sh EVSWARM SCHEMATHESIS [SECONDS] [SEED]
set -eu
evswarm=$1
schemathesis=$2
seconds=${3:-90}
seed=${4:-1}
here=$(cd "$(dirname "$0")" && pwd)
data=$(mktemp -d)
server=
trap 'test -z "$server" || kill "$server" 2>/dev/null || true; wait; rm -rf "$data"' EXIT

: >"$data/said"
"$evswarm" serve --listen 127.0.0.1:0 --data "$data/store" --threads 1 >"$data/said" 2>"$data/log" &
server=$!
url=
for try in $(seq 100); do
    url=$(sed -n 's|^evswarm listens on \(http://.*\)/$|\1|p' "$data/said")
    test -n "$url" && break
    sleep 0.1
done
test -n "$url" || { cat "$data/log"; exit 1; }

# Something to ask for: a job that is done, one that goes on, an arena of its own.
EVSWARM_SERVER=$url
export EVSWARM_SERVER
"$evswarm" submit "$here/small-job.json" --watch >/dev/null
"$evswarm" submit "$here/long-job.json" >/dev/null
EVSWARM_URL=$url
SCHEMATHESIS_HOOKS=$here/hooks.py
export EVSWARM_URL SCHEMATHESIS_HOOKS
cd "$data"

# What streams without an end (events, frames) is left to other tests. Whether right documents are taken is not
# asked: they may be refused for what no schema says, such as a robot that does not fit.
status=0
timeout $((seconds * 4 + 120)) "$schemathesis" --config-file "$here/schemathesis.toml" run "$url/openapi.json" \
    --exclude-path-regex '/(events|frames)$' \
    --phases examples,coverage,fuzzing --mode all --max-examples 25 --max-time "$seconds" \
    --seed "$seed" --request-timeout 20 --max-response-time 10 --no-shrink \
    --suppress-health-check all --continue-on-failure --max-failures 40 --warnings off || status=$?
kill -0 "$server" || { echo "the server is gone"; status=1; }
if grep -E 'panicked|"level":"ERROR"|ERROR' "$data/log"; then
    echo "the server's log tells of errors"
    status=1
fi
exit $status
