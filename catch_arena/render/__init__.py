"""Pictures of a World.

`shapes` are the words of a picture, `view` says how a match looks. `scene`, `marks`, `hud`, `standings`, `timeline` and
`news` describe, without a pixel; `raster`, `sprites` and `text` draw; `motion` knows any instant; `stage` puts frames
together, `video` and `encoders` write them to files, and `window` shows them. `moments` finds what is worth seeing;
`highlights`, `mosaic` and `sheet` are films and pictures of several parts.
"""
