"""Labels of a film: text, the footer, and the diagram of the energy."""
