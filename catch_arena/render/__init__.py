"""Pictures of a World: shapes (scene, hud), their pixels (raster), any instant (motion), MP4 (video) and a window."""
