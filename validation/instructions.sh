#!/usr/bin/env bash
# Instructions of three small solves, as valgrind counts them, against the counts kept beside this script: a change of
# more than 10 per cent is an error. Needs valgrind; times are too noisy for this.
#
#     validation/instructions.sh           compares
#     validation/instructions.sh --keep    keeps today's counts
set -euo pipefail
cd "$(dirname "$0")/.."
command -v valgrind >/dev/null || { echo "valgrind is not installed" >&2; exit 2; }
kept=validation/instructions.txt
cargo build --quiet --release
program=${CARGO_TARGET_DIR:-target}/release/pennate
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
[[ ${1:-} == --keep ]] && : >"$kept"
wrong=0
for network in dyad muscle_cantilever tripod; do
    valgrind --tool=callgrind --callgrind-out-file="$folder/out" \
        "$program" solve --threads 1 "models/networks/$network.toml" >/dev/null 2>"$folder/log"
    count=$(sed -n 's/.*Collected : //p' "$folder/log")
    if [[ ${1:-} == --keep ]]; then
        echo "$network $count" | tee -a "$kept"
        continue
    fi
    before=$(sed -n "s/^$network //p" "$kept")
    percent=$((100 * count / before))
    echo "$network: $count instructions, $percent per cent of $before"
    ((percent >= 90 && percent <= 110)) || wrong=1
done
exit $wrong
