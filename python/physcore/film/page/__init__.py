"""Pages that play a film in a browser: the drawn shapes on a tape, packed into one file with the code that shows them."""
