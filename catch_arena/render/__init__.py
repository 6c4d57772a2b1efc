"""Pictures of a World.

`shapes` are what a picture is described in, `viewport` says where the arena lies in it, `match_info` which names and
colours the hunters have. `scene`, `annotations`, `hud`, `team_scores`, `standings_animation`, `timeline` and
`event_feed` describe, without a pixel, `blurred_view` says what a hunter believes; `raster`, `sprites` and `text` draw.
`timing` says which instant a frame shows; `renderer` puts frames together, `video` and `encoders` write them to files,
and `window` shows them. `highlight_video` and `mosaic` are videos of several parts.
`optional_imports` is the one place that imports cv2 and pygame.
"""
