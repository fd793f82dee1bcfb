// What Material for MkDocs leaves to do for readers who use a keyboard or a screen reader: names, and a way to scroll tables and code.
const complete = () => {
  document.querySelector(".md-search")?.setAttribute("aria-label", "Search");
  for (const bar of document.querySelectorAll(".md-code__nav")) bar.role = "none";
  for (const box of document.querySelectorAll(".md-typeset__scrollwrap, .md-typeset pre > code")) {
    if (box.scrollWidth > box.clientWidth) box.tabIndex = 0;
    else box.removeAttribute("tabindex");
  }
  for (const box of document.querySelectorAll(".md-typeset__scrollwrap")) {
    box.role = "group";
    box.ariaLabel = "Table";
  }
};
addEventListener("resize", complete);
new MutationObserver(complete).observe(document.body, { childList: true, subtree: true });
complete();
