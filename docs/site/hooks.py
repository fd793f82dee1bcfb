"""MkDocs' hooks: pages outside docs/, links to any file of the repository, commands that wrap between words.

README.md is the first page. A file outside docs/ that a page links to (`../LICENSE`) becomes part of the site, as text.
"""
import pathlib
import re

from mkdocs.structure.files import File
from mkdocs.structure.nav import Link

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGES = {"README.md": "index.md", "CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md"}
ASSETS = ("extra.css", "extra.js", "iframe-worker.js")
LINK = re.compile(r"(\]\()([^)#\s:]+)((?:#[^)\s]*)?\))")
CODE = re.compile(r"`[^`]*`")
COMMANDS = re.compile(r'(<div class="language-sh highlight">.*?<code>)(.*?)\n?(</code>)', re.DOTALL)
HYPHENATED = re.compile(r"(?<![^\s>])[^\s<>]*-[^\s<>]*(?![^<>]*>)")
CPP = "cpp/index.html"  # Doxygen writes it after MkDocs


def of_repository(page: str, target: str) -> pathlib.Path:
    """The file that a link of a page, both relative to the repository, names."""
    return ((ROOT / page).parent / target).resolve()


def of_site(path: pathlib.Path) -> str:
    """Where a file of the repository is in the site."""
    name = path.relative_to(ROOT).as_posix()
    if name.startswith("docs/"):
        return name.removeprefix("docs/")
    return PAGES.get(name) or f"files/{name}.txt"


def source_of(file: File) -> str:
    return pathlib.Path(file.abs_src_path).resolve().relative_to(ROOT).as_posix()


def on_config(config):
    # A page for missing pages and a map of the site need to know the site's address.
    config.theme.static_templates = set()
    return config


def on_files(files, config):
    for asset in ASSETS:
        files.append(File.generated(config, f"assets/{asset}", abs_src_path=str(ROOT / "docs/site" / asset)))
    for name, uri in PAGES.items():
        files.append(File.generated(config, uri, abs_src_path=str(ROOT / name)))
    for page in list(files.documentation_pages()):
        for _, target, _ in LINK.findall(page.content_string):
            path = of_repository(source_of(page), target)
            uri = of_site(path) if path.is_relative_to(ROOT) else ""
            if uri.startswith("files/") and path.is_file() and not files.get_file_from_path(uri):
                files.append(File.generated(config, uri, abs_src_path=str(path)))
    return files


def on_page_markdown(markdown, page, **_):
    def to_site(match):
        path = of_repository(source_of(page.file), match[2])
        return f"{match[1]}{of_site(path)}{match[3]}" if path.is_relative_to(ROOT) and path.is_file() else match[0]

    # In tables, GitHub reads `a\|b` as a|b; Python-Markdown needs no backslash.
    lines = [CODE.sub(lambda code: code[0].replace(r"\|", "|"), line) if line.startswith("|") else line for line in markdown.split("\n")]
    return LINK.sub(to_site, "\n".join(lines))


def on_page_content(html, **_):
    # A browser would break --option after its first hyphen. Elements for extra.css: a command is a line.
    def lines(block):
        words = HYPHENATED.sub(r'<span class="word">\g<0></span>', block[2])
        return block[1] + "".join(f'<span class="command">{line}\n</span>' for line in words.split("\n")) + block[3]

    return COMMANDS.sub(lines, html)


def on_nav(nav, **_):
    for section in nav.items:
        if section.title == "Reference":
            section.children.append(Link("C++ reference", CPP))
    return nav
