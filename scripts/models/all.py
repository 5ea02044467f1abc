"""Writes all meshes, textures and generated scenes again: python3 scripts/models/all.py"""

import board
import candle
import chess
import chess_scenes
import effect_scenes
import perfume
import room
import rose
import rose_scene
import still_life
import street
import textures

for module in (board, candle, chess, perfume, room, rose, still_life, textures, chess_scenes,
               effect_scenes, rose_scene, street):
    module.build()
