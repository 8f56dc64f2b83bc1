"""Pages that play a film in a browser: its shapes on a tape, packed into one file with the code that draws them."""
