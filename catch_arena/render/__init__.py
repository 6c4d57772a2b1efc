"""Pictures of a World: shapes (scene, hud), their pixels (raster), frames at any instant (motion), MP4 (video) and a window."""
