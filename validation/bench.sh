#!/usr/bin/env bash
# Error against run time on seven problems, of pennate and of other programs, one after the other on this machine:
# a table and a picture, docs/error_time.md and docs/error_time.svg. Ten minutes or so, best with nothing else running.
#
#     validation/bench.sh             everything
#     validation/bench.sh --chart     table and picture from the last measurements, in validation/out/bench
set -euo pipefail
cd "$(dirname "$0")/.."
out=validation/out/bench
python=validation/.venv/bin/python
mkdir -p "$out"
validation/setup.sh bench >/dev/null
if [[ ${1:-} != --chart ]]; then
    cargo run --quiet --release --example formulations -- --csv >"$out/pennate.csv"
    "$python" validation/bench/measure.py >"$out/others.csv"
fi
"$python" validation/bench/chart.py "$out/pennate.csv" "$out/others.csv" docs/error_time.svg docs/error_time.md
