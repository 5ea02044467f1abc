"""Writes all meshes, textures and generated scenes again: python3 scripts/models/all.py"""

import ball
import board
import candle
import caustics
import chess
import chess_scenes
import effect_scenes
import flag
import fools_mate
import forest
import perfume
import pool
import room
import rose
import rose_scene
import still_life
import street
import textures

for module in (board, candle, caustics, chess, flag, forest, perfume, pool, room, rose, still_life, textures, ball,
               chess_scenes, effect_scenes, fools_mate, rose_scene, street):
    module.build()
