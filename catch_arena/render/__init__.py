"""Pictures of a World.

`shapes` defines the shapes of a picture, `viewport` the place of the arena in it, and `match_info` the names and
colours of the agents. `scene`, `annotations`, `captions`, `lens`, `cards`, `ghost`, `hud`, `team_scores`,
`standings_animation`, `timeline` and `event_feed` describe pictures as shapes, and `blurred_view` computes the beliefs
of a hunter. `raster`, `sprites` and `text` draw pixels. `timing` computes the instant that a frame shows, `renderer`
puts frames together, `video` and `encoders` write them to files, and `window` shows them. `highlight_video` and
`mosaic` write videos of several parts, and `env_display` shows an env. `optional_imports` is the only module that
imports cv2 and pygame.
"""
