"""From where a scene is seen: views, cameras that move, and what they leave open."""
