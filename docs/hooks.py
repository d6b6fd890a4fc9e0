"""Keeps the book free of the network: what its theme would load from elsewhere comes from assets/."""

from mkdocs.utils import get_relative_url

ELSEWHERE = "https://unpkg.com/iframe-worker/shim"


def on_post_page(output, page, config):
    return output.replace(ELSEWHERE, get_relative_url("assets/iframe-worker/shim.js", page.url))


def on_post_template(output_content, template_name, config):
    return output_content.replace(ELSEWHERE, "assets/iframe-worker/shim.js")
