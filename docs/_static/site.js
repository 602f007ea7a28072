// What the theme leaves out for the keyboard and for screen readers.
for (const [selector, name] of [[".sidebar-drawer", "Site"], [".toc-drawer", "This page"]]) {
  document.querySelector(selector)?.setAttribute("aria-label", name);
}
// A box that scrolls can be reached with Tab.
function reach() {
  for (const box of document.querySelectorAll("pre, .table-wrapper, .math, .output")) {
    if (box.scrollWidth > box.clientWidth || box.scrollHeight > box.clientHeight) box.tabIndex = 0;
    else box.removeAttribute("tabindex");
  }
}
new ResizeObserver(reach).observe(document.body);
