"""Write every mesh, texture and generated scene again: python3 scripts/models/all.py"""

import board
import chess
import chess_scenes
import textures

for module in (board, chess, textures, chess_scenes):
    module.build()
