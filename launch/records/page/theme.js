// Dark or light theme: that of the system until the user selects one. The colours come from the style sheet.
const root = document.documentElement;

function isDark() {
  const system = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
  return (root.dataset.theme ?? system) === "dark";
}

const colours = new Map();

// Current value of a colour of the style sheet. The values are cached, because a query takes a fraction of a millisecond.
function colour(name) {
  if (!colours.has(name)) {
    root.style.accentColor = `var(--${name})`;
    colours.set(name, getComputedStyle(root).accentColor);
    root.style.accentColor = "";
  }
  return colours.get(name);
}

const clearColours = () => colours.clear();
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", clearColours);
root.addEventListener("themed", clearColours);

// Calls `draw` now and after each change of the theme.
function whenThemed(draw) {
  draw();
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  root.addEventListener("themed", draw);
}

document.getElementById("theme").addEventListener("click", () => {
  root.dataset.theme = isDark() ? "light" : "dark";
  root.dispatchEvent(new Event("themed"));
});

