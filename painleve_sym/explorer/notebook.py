"""The explorer as a widget of notebooks, by anywidget."""

from __future__ import annotations

import anywidget
import traitlets

from painleve_sym.explorer.script import script, web_text

_RENDER = """
function render({ model, el }) {
  const root = document.createElement("div");
  el.append(root);
  const options = {
    link: false,
    onchange: (settings) => {
      model.set("settings", settings);
      model.save_changes();
    },
  };
  modules["page.js"].mount(root, model.get("data"), options).catch((error) => {
    root.textContent = `The explorer cannot compute: ${error.message}.`;
  });
}
export default { render };
"""


class ExplorerWidget(anywidget.AnyWidget):
    """The page of a mechanism within a notebook.

    `data` is everything the page is made of. `settings` is what is shown now: ``values`` of states
    and parameters, ``force``, ``end``, …; empty until something is changed.
    """

    _esm = script() + _RENDER
    _css = web_text("style.css")
    data = traitlets.Dict().tag(sync=True)
    settings = traitlets.Dict().tag(sync=True)

    @property
    def values(self) -> dict[str, float]:
        """States and parameters that are shown now, by name."""
        description = self.data["description"]
        quantities = (*description["states"], *description["parameters"])
        first = {q["name"]: q["value"] for q in quantities}
        shown = self.settings or self.data["initial"]
        values: dict[str, float] = first | shown.get("values", {})
        return values
