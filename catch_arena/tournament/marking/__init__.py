"""One agent on its own: is it fit to play, and how good is it by a teacher's spec?"""
