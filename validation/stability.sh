#!/usr/bin/env bash
# Everything that is measured of singular points, random networks and frequencies, as three tables; some minutes.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo run --quiet --release --example singular_points
echo
cargo run --quiet --release --example mechanisms
echo
cargo build --quiet --release
python3 validation/frequencies.py target/release/pennate
