"""What the book needs beyond MkDocs: no scripts from elsewhere, and no file named that is not there."""

import logging
import pathlib
import re

from mkdocs.utils import get_relative_url

ROOT = pathlib.Path(__file__).resolve().parent.parent
ELSEWHERE = "https://unpkg.com/iframe-worker/shim"
FOLDERS = "elements|solver|models|analysis|src|testing|tests|benches|examples|validation|docs|\\.ci"
# A file or folder of the repository, such as `solver/src/chain/`.
NAMED = re.compile(rf"`((?:{FOLDERS})/[\w./-]*)`")
# What commands make.
MADE = ("validation/.venv",)

log = logging.getLogger("mkdocs.hooks")


def on_page_markdown(markdown, page, config, files):
    """A warning, and so an error of the build, for each file that a page names and the repository lacks."""
    for name in NAMED.findall(markdown):
        folder = ROOT / name.split("/")[0]
        if folder.is_dir() and not (ROOT / name).exists() and not name.startswith(MADE):
            log.warning("%s names %s, which is not there", page.file.src_path, name)


def on_post_page(output, page, config):
    return output.replace(ELSEWHERE, get_relative_url("assets/iframe-worker/shim.js", page.url))


def on_post_template(output_content, template_name, config):
    return output_content.replace(ELSEWHERE, "assets/iframe-worker/shim.js")
