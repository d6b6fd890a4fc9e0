#!/bin/sh
# Builds the book into target/book; a link that leads nowhere is an error.
#
#     docs/build.sh            then open target/book/index.html
#     docs/build.sh serve      shows it at http://127.0.0.1:8000 and follows changes
set -eu
export NO_MKDOCS_2_WARNING=1
cd "$(dirname "$0")/.."

PYTHON=${PYTHON:-python3}
if ! "$PYTHON" -c 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
    echo "docs/build.sh: needs Python 3.11 or newer with venv (Debian: apt-get install python3-venv)" >&2
    exit 1
fi

venv=target/book-venv
[ -x $venv/bin/python ] || "$PYTHON" -m venv $venv
# Installed once for each list of requirements.
if ! cmp -s docs/requirements.txt $venv/requirements.txt; then
    $venv/bin/python -m pip install --quiet --disable-pip-version-check -r docs/requirements.txt
    cp docs/requirements.txt $venv/requirements.txt
fi
if [ "${1:-}" = serve ]; then
    exec $venv/bin/mkdocs serve
fi
exec $venv/bin/mkdocs build --strict --clean --site-dir target/book
