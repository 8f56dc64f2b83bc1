"""What is written and drawn beside the picture: text, the footer, and the diagram of the energy."""
