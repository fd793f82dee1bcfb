"""MkDocs' hooks: pages outside docs/, notebooks as pages, links to any file of the repository, commands that wrap between words.

README.md is the first page. A file outside docs/ that a page links to (`../LICENSE`) becomes part of the site, as text.
"""
import base64
import json
import pathlib
import re

from mkdocs.structure.files import File
from mkdocs.structure.nav import Link

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGES = {"README.md": "index.md", "CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md"}
NOTEBOOKS = ROOT / "examples/notebooks"
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
    if path.parent == NOTEBOOKS:
        return f"notebooks/{path.stem}.md"
    return PAGES.get(name) or f"files/{name}.txt"


def shown(output, uri, pictures):
    """An output of a notebook's cell as Markdown; its picture joins `pictures`, {address in the site: bytes}."""
    data = output.get("data", {})
    if "image/png" in data:
        name = f"{uri.removesuffix('.md')}-{len(pictures) + 1}.png"
        pictures[name] = base64.b64decode("".join(data["image/png"]))
        return f"![What the cell above draws]({name.rsplit('/', 1)[-1]})"
    return "```text\n" + "".join(output.get("text") or data.get("text/plain", "")).rstrip() + "\n```"


def page_of(notebook, uri):
    """Markdown and pictures of a notebook as it is stored, with what its cells put out."""
    parts, pictures = [], {}
    for cell in json.loads(notebook.read_text(encoding="utf-8"))["cells"]:
        source = "".join(cell["source"])
        parts.append(source if cell["cell_type"] == "markdown" else f"```python\n{source}\n```")
        parts += [shown(output, uri, pictures) for output in cell.get("outputs", [])]
    return "\n\n".join(parts) + "\n", pictures


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
    for notebook in sorted(NOTEBOOKS.glob("*.ipynb")):
        uri = f"notebooks/{notebook.stem}.md"
        text, pictures = page_of(notebook, uri)
        files.append(File.generated(config, uri, content=text))
        for name, picture in pictures.items():
            files.append(File.generated(config, name, content=picture))
    for page in list(files.documentation_pages()):
        if not page.abs_src_path:
            continue
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

    if not page.file.abs_src_path:  # a notebook, without links
        return markdown
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
