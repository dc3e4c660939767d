"""The project's page on a package index: the README, without links that only a checkout can follow.

Everything else that a build needs is in pyproject.toml.
"""

import re
from pathlib import Path

from setuptools import setup

IMAGE = re.compile(r"!\[[^\]]*\]\((?!https?://)([^)\s]+)\)")
LINK = re.compile(r"\[([^\]]+)\]\((?!https?://)([^)#\s]*)(?:#[^)\s]*)?\)")


def package_page(readme: str) -> str:
    """Return a README for readers who do not have the files that its links lead to.

    A picture becomes its file's name in the source; a link its words, with that name where the
    words are not that already.

    Args:
        readme: Markdown, its links relative to the repository.
    """

    def words(link: re.Match[str]) -> str:
        text, file = link.groups()
        return text if not file or text == file else f"{text} (`{file}` in the source)"

    return LINK.sub(words, IMAGE.sub(r"(Picture: `\1` in the source.)", readme))


if __name__ == "__main__":
    readme = Path(__file__).with_name("README.md").read_text(encoding="utf-8")
    setup(long_description=package_page(readme), long_description_content_type="text/markdown")
