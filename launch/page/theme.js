// Dark or light: the system's choice until somebody makes another. Colours are those of the style sheet.
const root = document.documentElement;

function isDark() {
  const system = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
  return (root.dataset.theme ?? system) === "dark";
}

/// The colour that the style sheet has under a name, as it is now.
function colour(name) {
  root.style.accentColor = `var(--${name})`;
  return getComputedStyle(root).accentColor;
}

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

