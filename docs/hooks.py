"""What the book needs beyond MkDocs: no scripts from elsewhere, and no file or equation named that is not there."""

import logging
import pathlib
import re

from mkdocs.utils import get_relative_url

ROOT = pathlib.Path(__file__).resolve().parent.parent
ELSEWHERE = "https://unpkg.com/iframe-worker/shim"
FOLDERS = "elements|chains|solver|models|analysis|bindings|src|testing|tests|benches|examples|validation|docs|\\.ci"
# A file or folder of the repository, such as `solver/src/path/`.
NAMED = re.compile(rf"`((?:{FOLDERS})/[\w./-]*)`")
# What heads of source files cite: a page of the theory, and equations of it.
CITED = re.compile(r"docs/theory/([\w-]+\.md)((?:,? (?:Eq\.|to|and)? ?\d+\.\d+)*)")
# What commands make.
MADE = ("validation/.venv",)

log = logging.getLogger("mkdocs.hooks")


def on_page_markdown(markdown, page, config, files):
    """A warning, and so an error of the build, for each file that a page names and the repository lacks."""
    for name in NAMED.findall(markdown):
        folder = ROOT / name.split("/")[0]
        if folder.is_dir() and not (ROOT / name).exists() and not name.startswith(MADE):
            log.warning("%s names %s, which is not there", page.file.src_path, name)


def on_pre_build(config):
    """The same for pages and equations of the theory that source files cite."""
    for folder in FOLDERS.split("|"):
        for source in (ROOT / folder).rglob("*.rs"):
            for page, equations in CITED.findall(source.read_text(encoding="utf-8")):
                theory = ROOT / "docs" / "theory" / page
                text = theory.read_text(encoding="utf-8") if theory.exists() else ""
                missing = [each for each in re.findall(r"\d+\.\d+", equations) if rf"\tag{{{each}}}" not in text]
                if missing or not text:
                    log.warning("%s cites %s, equations %s, which are not there", source, page, missing)


def on_post_page(output, page, config):
    return output.replace(ELSEWHERE, get_relative_url("assets/iframe-worker/shim.js", page.url))


def on_post_template(output_content, template_name, config):
    return output_content.replace(ELSEWHERE, "assets/iframe-worker/shim.js")
