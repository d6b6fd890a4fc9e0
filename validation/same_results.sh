#!/usr/bin/env bash
# Whether two builds of the program say the same, byte by byte, times apart.
#
#     validation/same_results.sh OLD NEW
#
# Each of the two is a program, or a directory with what an earlier comparison had a program say: the answers of the second
# stay in target/same_results/new, so that a program need not answer twice. Compared are files, tables, messages and exit
# status: every network of the repository and every scene is solved, small networks are asked for their modes and their
# buckling; pictures, other accuracies, sweeps, fits and what is refused are compared for a few.
set -euo pipefail
cd "$(dirname "$0")/.."

if [[ $# -ne 2 ]]; then
    sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//;p}' "$0"
    exit 2
fi

answers=target/same_results

# Runs the program, and keeps what it says and how it ends; times are cut out. NAME is a directory of answers: @ in the
# arguments stands for it.
answer() {
    local name=$1 status=0
    shift
    mkdir -p "$name"
    "$program" "${@//@/$name}" >"$name/stdout" 2>"$name/stderr" </dev/null || status=$?
    echo "$status" >"$name/status"
    sed -i -E 's/(Took )[0-9.]+ (ms|s)/\1/' "$name/stdout"
    sed -i "s|$into/||g" "$name/stdout" "$name/stderr"
    find "$name" -type f \( -name '*.json' -o -name stdout \) -exec sed -i '/^  "timing": {$/,/^  }/d' {} +
}

# What is asked about every network.
network() {
    answer "$into/solve/$1" solve "$2" -o @
    answer "$into/printed/$1" solve "$2" --json --accuracy 1e-3
    answer "$into/fine/$1" solve "$2" -o @ --accuracy 1e-9
}

# All that a program says, into a directory.
ask() {
    program=$(realpath "$1")
    local into=$2 file scene
    rm -rf "$into"
    mkdir -p "$into"
    while read -r file; do
        network "$file" "$file"
        # The spectra of large networks take minutes.
        if [[ $(grep -c '^ *"axial_force"' "$into/solve/$file/results.json") -lt 20 ]]; then
            answer "$into/modes/$file" modes "$file" -o @ --accuracy 0.5
            answer "$into/buckle/$file" buckle "$file" -o @ --accuracy 0.5 --count 3
        fi
    done < <(grep -lrE '^ *"?format"? *[=:] *"pennate/1"' models validation tests --include='*.toml' --include='*.json' | sort)
    answer "$into/schema" schema
    "$program" scene | sed -n 's/^\([a-z_0-9]\{1,\}\) .*/\1/p' >"$into/scenes"
    while read -r scene; do
        "$program" scene "$scene" >"$into/scene.toml"
        network "scene/$scene" "$into/scene.toml"
    done <"$into/scenes"
    for file in models/networks/dyad validation/05_lee_frame/jump validation/18_helix_actuated/helix; do
        answer "$into/pictures/$file" solve "$file.toml" -o @ --vtk
        answer "$into/threads/$file" solve "$file.toml" -o @ --threads 2
        answer "$into/modes-pictures/$file" modes "$file.toml" -o @ --vtk
    done
    for file in 19_natural_frequencies/cantilever 19_natural_frequencies/hsim columns/clamped; do
        answer "$into/modes/1e-6/$file" modes "validation/$file.toml" -o @ --threads 2
        answer "$into/modes/1e-12/$file" modes "validation/$file.toml" -o @ --accuracy 1e-12
    done
    for file in 10_euler_post_buckling/column columns/cantilever columns/clamped 13_pennate_dyad/loaded; do
        answer "$into/buckle/1e-6/$file" buckle "validation/$file.toml" -o @
        answer "$into/buckle/1e-10/$file" buckle "validation/$file.toml" -o @ --accuracy 1e-10
    done
    answer "$into/buckle/no-step" buckle models/networks/dyad.toml --step nowhere
    answer "$into/refused/accuracy" solve models/networks/dyad.toml --set beta=95
    answer "$into/refused/missing" solve no/such/file.toml
    answer "$into/sweep/dyad" sweep models/networks/dyad.toml -o @ --vary beta=20:50:2 --vary L=120,130
    answer "$into/sweep/one" sweep models/networks/dyad.toml -o @ --vary beta=20:90:7 --threads 1 --accuracy 1e-8
    answer "$into/sweep/unknown" sweep models/networks/dyad.toml -o @ --vary gamma=1:3:1
    for length in "" "--end-length fit" "--two-moduli" "--method nelder-mead" "--shear --min-ovality 0.93"; do
        # shellcheck disable=SC2086  # several words
        answer "$into/fit/${length// /_}" fit validation/hifi/load_cases.csv --variant A --diameter 13 --wall 2 $length \
            -o @/muscle.toml --check --plot @/check.svg --curves @/curves.svg
    done
}

# The directory of answers of a program; a directory is one.
answers_of() {
    if [[ -d $1 ]]; then
        echo "$1"
    else
        ask "$1" "$answers/$2" >&2
        echo "$answers/$2"
    fi
}

old=$(answers_of "$1" old)
new=$(answers_of "$2" new)
if diff -rq "$old" "$new"; then
    echo "the same: $(find "$new" -name status | wc -l) answers, $(find "$new" -type f | wc -l) files"
else
    exit 1
fi
