// Dark or light: the system's choice until somebody makes another. Colours are those of the style sheet.
const root = document.documentElement;

function isDark() {
  const system = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
  return (root.dataset.theme ?? system) === "dark";
}

const colours = new Map();

/// The colour that the style sheet has under a name, as it is now. To ask takes a fraction of a millisecond, hence once.
function colour(name) {
  if (!colours.has(name)) {
    root.style.accentColor = `var(--${name})`;
    colours.set(name, getComputedStyle(root).accentColor);
    root.style.accentColor = "";
  }
  return colours.get(name);
}

const forget = () => colours.clear();
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", forget);
root.addEventListener("themed", forget);

/// Calls at once, and whenever the colours have changed.
function whenThemed(draw) {
  draw();
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  root.addEventListener("themed", draw);
}

document.getElementById("theme").addEventListener("click", () => {
  root.dataset.theme = isDark() ? "light" : "dark";
  root.dispatchEvent(new Event("themed"));
});

