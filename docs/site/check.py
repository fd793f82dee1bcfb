#!/usr/bin/env python3
"""Every link of a built site leads to a file and an anchor that exist, and no page loads anything from another host.

Usage: check.py SITE
"""
import pathlib
import re
import sys
import urllib.parse

LOADS = {"script", "img", "iframe", "link", "source", "video", "audio", "object", "embed"}
REFERENCE = re.compile(r"""<(\w+)\b[^<>]*?\s(?:href|src|data)="([^"]*)\"""")
ANCHOR = re.compile(r"""\s(?:id|name)="([^"]*)\"""")
# Doxygen 1.9 links to the list of nested classes of a class whose nested classes are all private, and has no such list.
DOXYGEN = "nested-classes"
STYLE = re.compile(r"""url\(\s*['"]?((?:https?:)?//[^'")]*)|@import\s+['"]([^'"]*)""")


def main():
    site = pathlib.Path(sys.argv[1]).resolve()
    texts = {page: page.read_text(encoding="utf-8") for page in site.rglob("*.html")}
    anchors = {page: set(ANCHOR.findall(text)) for page, text in texts.items()}
    found, links, exists = set(), 0, {}
    for page, text in texts.items():
        name = page.relative_to(site)
        for tag, target in set(REFERENCE.findall(text)):
            url = urllib.parse.urlsplit(target.replace("&amp;", "&"))
            if url.scheme or url.netloc:
                if tag in LOADS and url.scheme not in ("data", "javascript"):
                    found.add(f"{name}: <{tag}> loads {target}")
                continue
            links += 1
            path = page if not url.path else (page.parent / urllib.parse.unquote(url.path)).resolve()
            if path not in exists:
                exists[path] = path.is_relative_to(site) and path.is_file()
            if not exists[path]:
                found.add(f"{name}: no {target}")
            elif url.fragment and path in anchors and urllib.parse.unquote(url.fragment) not in anchors[path] and url.fragment != DOXYGEN:
                found.add(f"{name}: {target} has no such anchor")
    for style in site.rglob("*.css"):
        found |= {f"{style.relative_to(site)} loads {one or other}" for one, other in STYLE.findall(style.read_text(encoding="utf-8"))}
    if len(texts) < 10 or links < 1000:
        found.add(f"{site} has {len(texts)} pages with {links} links: this is not the whole site")
    print("\n".join(sorted(found)) if found else f"site: {links} links of {len(texts)} pages ok")
    return 1 if found else 0


sys.exit(main())
