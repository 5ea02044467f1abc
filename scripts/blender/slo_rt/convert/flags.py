# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of how slo-rt handles each property of Blender's data.

Every property that an artist can set is in one of three lists of its kind: `read` (the exporter
reads it, Blender itself applies it, or code notes it), `listed` (noted unless it has the value at
which it has no effect), or `idle` (it does not affect the picture: it concerns the user interface,
other engines, or objects that are not exported anyway). A test compares the tables with Blender's
own, so that no property of a new version is forgotten.
"""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Table:
    """Properties of a kind of data; `listed` has `(neutral value, what is noted)`."""

    read: frozenset
    idle: frozenset
    listed: dict = field(default_factory=dict)


def _table(read="", idle="", **listed):
    return Table(frozenset(read.split()), frozenset(idle.split()), listed)


def note_flags(owner, kind, subject, report):
    """Notes properties of `owner` that are set and have no counterpart; `owner` may be None, as
    settings of Cycles are if it is switched off."""
    if owner is None:
        return
    for name, (neutral, message) in TABLES[kind].listed.items():
        value = getattr(owner, name, neutral)
        if value != neutral:
            report.note(subject, message.format(value=_word(value)))


def _word(value):
    return f"{value:g}" if isinstance(value, float) else str(value).lower().replace("_", " ")


_CAUSTICS = "caustics are not carried"
_EEVEE = "its {} factor of {{value}} is not carried"

TABLES = {
    "RenderSettings": _table(
        read="""
        resolution_x resolution_y resolution_percentage pixel_aspect_x pixel_aspect_y fps fps_base
        frame_map_old frame_map_new film_transparent use_freestyle use_motion_blur
        motion_blur_shutter motion_blur_position motion_blur_shutter_curve use_border border_min_x
        border_min_y border_max_x border_max_y use_crop_to_border use_compositing use_sequencer
        use_multiview views stereo_views views_format use_single_layer engine use_simplify
        simplify_subdivision_render simplify_child_particles_render use_stamp threads threads_mode
        """,
        idle="""
        image_settings preview_pixel_size ppm_factor ppm_base ffmpeg dither_intensity filter_size
        hair_type hair_subdiv use_high_quality_normals use_placeholder use_overwrite
        use_file_extension use_lock_interface filepath use_render_cache use_stamp_time
        use_stamp_date use_stamp_frame use_stamp_frame_range use_stamp_camera use_stamp_lens
        use_stamp_scene use_stamp_note use_stamp_marker use_stamp_filename
        use_stamp_sequencer_strip use_stamp_render_time stamp_note_text use_stamp_labels
        metadata_input use_stamp_memory use_stamp_hostname stamp_font_size stamp_foreground
        stamp_background sequencer_gl_preview use_sequencer_override_scene_strip
        simplify_subdivision simplify_child_particles simplify_volumes use_simplify_normals
        simplify_gpencil simplify_gpencil_onplay simplify_gpencil_antialiasing
        simplify_gpencil_view_fill simplify_gpencil_modifier simplify_gpencil_shader_fx
        simplify_gpencil_tint simplify_shadows simplify_shadows_render use_persistent_data
        line_thickness_mode line_thickness bake bake_type use_bake_selected_to_active use_bake_clear
        bake_margin bake_margin_type bake_bias use_bake_multires use_bake_lores_mesh bake_samples
        use_bake_user_scale bake_user_scale compositor_device compositor_precision
        compositor_denoise_device compositor_denoise_preview_quality
        compositor_denoise_final_quality
        """,
    ),
    "ViewLayer": _table(
        read="""
        name material_override world_override use_solid use_sky use_strand use_motion_blur use
        use_freestyle layer_collection objects aovs use_pass_combined use_pass_cryptomatte_accurate
        """,
        idle="""
        pass_alpha_threshold eevee active_aov active_aov_index lightgroups active_lightgroup
        active_lightgroup_index pass_cryptomatte_depth active_layer_collection freestyle_settings
        depsgraph cycles use_ao use_volumes use_grease_pencil
        """,
        samples=(0, "its own {value} samples are not carried, those of slo-rt's settings count"),
    ),
    "Camera": _table(
        read="""
        type sensor_fit sensor_width sensor_height lens ortho_scale angle angle_x angle_y clip_start
        clip_end shift_x shift_y dof
        """,
        idle="""
        passepartout_alpha display_size stereo show_limits show_mist show_passepartout
        show_safe_areas show_safe_center show_name show_sensor show_background_images lens_unit
        composition_guide_color show_composition_center show_composition_center_diagonal
        show_composition_thirds show_composition_golden show_composition_golden_tria_a
        show_composition_golden_tria_b show_composition_harmony_tri_a show_composition_harmony_tri_b
        panorama_type fisheye_fov fisheye_lens latitude_min latitude_max longitude_min longitude_max
        fisheye_polynomial_k0 fisheye_polynomial_k1 fisheye_polynomial_k2 fisheye_polynomial_k3
        fisheye_polynomial_k4 central_cylindrical_range_u_min central_cylindrical_range_u_max
        central_cylindrical_range_v_min central_cylindrical_range_v_max central_cylindrical_radius
        custom_filepath custom_shader custom_mode custom_bytecode custom_bytecode_hash
        background_images cycles_custom
        """,
    ),
    "CameraDOFSettings": _table(
        read="""
        use_dof focus_object focus_subtarget focus_distance aperture_fstop aperture_blades
        aperture_ratio
        """,
        idle="aperture_rotation",  # only affects blades and ratio, which are noted
    ),
    "Light": _table(
        read="""
        type use_temperature color temperature use_shadow exposure normalize node_tree use_nodes
        energy shadow_soft_size angle shape size size_y spread spot_blend spot_size
        use_soft_falloff slo_rt cycles
        """,
        idle="""
        volume_factor cutoff_distance shadow_buffer_clip_start shadow_filter_radius
        shadow_maximum_resolution use_shadow_jitter shadow_jitter_overblur use_absolute_resolution
        shadow_cascade_max_distance shadow_cascade_count shadow_cascade_exponent
        shadow_cascade_fade use_square show_cone
        """,
        diffuse_factor=(1.0, _EEVEE.format("diffuse")),
        specular_factor=(1.0, _EEVEE.format("specular")),
        transmission_factor=(1.0, _EEVEE.format("transmission")),
        use_custom_distance=(False, "shines at any distance, whatever its custom distance"),
    ),
    "CyclesLightSettings": _table(
        read="name is_portal",
        idle="use_multiple_importance_sampling",
        max_bounces=(1024, "lights all bounces, whatever its maximum of {value}"),
        is_caustics_light=(False, _CAUSTICS),
    ),
    "World": _table(
        read="color node_tree use_nodes cycles_visibility cycles lightgroup",
        idle="""
        light_settings mist_settings use_eevee_finite_volume probe_resolution
        sun_threshold sun_angle use_sun_shadow sun_shadow_maximum_resolution
        sun_shadow_filter_radius use_sun_shadow_jitter sun_shadow_jitter_overblur
        """,
    ),
    "CyclesWorldSettings": _table(
        read="name",
        idle="""
        sampling_method sample_map_resolution volume_sampling volume_interpolation volume_step_size
        homogeneous_volume
        """,
        max_bounces=(1024, "lights all bounces, whatever its maximum of {value}"),
        is_caustics_light=(False, _CAUSTICS),
    ),
    "Material": _table(
        read="node_tree use_nodes diffuse_color roughness metallic slo_rt cycles",
        idle="""
        surface_render_method displacement_method blend_method alpha_threshold
        use_transparency_overlap show_transparent_back use_backface_culling_lightprobe_volume
        use_raytrace_refraction use_screen_refraction use_sss_translucency refraction_depth
        thickness_mode use_thickness_from_shadow volume_intersection_method max_vertex_displacement
        preview_render_type use_preview_world pass_index texture_paint_images texture_paint_slots
        paint_active_slot paint_clone_slot specular_color specular_intensity line_color
        line_priority grease_pencil lineart
        """,
        use_backface_culling=(False, "both sides are seen, whatever Backface Culling says"),
        use_backface_culling_shadow=(False, "both sides throw shadows, whatever Backface Culling says"),
        use_transparent_shadow=(True, "Transparent Shadows that are switched off are not carried"),
    ),
    "CyclesMaterialSettings": _table(
        read="name emission_sampling",
        idle="""
        use_bump_map_correction volume_sampling volume_interpolation
        volume_step_rate homogeneous_volume
        """,
    ),
    "Object": _table(
        read="""
        data parent parent_type parent_vertices parent_bone use_parent_final_indices track_axis
        up_axis material_slots active_material location rotation_quaternion rotation_axis_angle
        rotation_euler rotation_mode scale dimensions delta_location delta_rotation_euler
        delta_rotation_quaternion delta_scale matrix_world matrix_local matrix_basis
        matrix_parent_inverse modifiers constraints vertex_groups add_rest_position_attribute field
        collision soft_body particle_systems rigid_body rigid_body_constraint use_simulation_cache
        hide_render show_instancer_for_render visible_camera visible_diffuse visible_glossy
        visible_transmission visible_shadow is_holdout is_shadow_catcher instance_type
        use_instance_vertices_rotation use_instance_faces_scale instance_faces_scale
        instance_collection pose light_linking lightgroup cycles active_shape_key
        show_only_shape_key
        """,
        idle="""
        use_camera_lock_parent active_material_index lock_location lock_rotation lock_rotation_w
        lock_rotations_4d lock_scale shader_effects empty_display_type empty_display_size
        empty_image_offset image_user empty_image_depth show_empty_image_perspective
        show_empty_image_orthographic show_empty_image_only_axis_aligned use_empty_image_alpha
        empty_image_side pass_index color hide_viewport hide_select hide_probe_volume
        hide_probe_sphere hide_probe_plane hide_surface_pick show_instancer_for_viewport
        visible_volume_scatter display_type show_bounds display_bounds_type show_name show_axis
        show_texture_space show_wire show_all_edges use_grease_pencil_lights show_transparent
        show_in_front use_shape_key_edit_mode active_shape_key_index display lineart
        use_mesh_mirror_x use_mesh_mirror_y use_mesh_mirror_z
        shadow_terminator_normal_offset shadow_terminator_geometry_offset
        shadow_terminator_shading_offset animation_visualization motion_path selection_sets
        active_selection_set
        """,
    ),
    "CyclesObjectSettings": _table(
        read="name use_motion_blur use_deform_motion",
        idle="""
        motion_steps use_camera_cull use_distance_cull shadow_terminator_offset
        shadow_terminator_geometry_offset ao_distance dicing_rate
        """,
        use_adaptive_subdivision=(False, "adaptive subdivision is not carried, that for rendering is"),
        is_caustics_caster=(False, _CAUSTICS),
        is_caustics_receiver=(False, _CAUSTICS),
    ),
    "LayerCollection": _table(
        read="collection children exclude holdout indirect_only", idle="hide_viewport"
    ),
    # Settings of Cycles that artists expect to keep after changing the engine; the others concern
    # how Cycles computes.
    "CyclesRenderSettings": _table(
        film_exposure=(1.0, "Cycles' film exposure of {value} is not carried"),
        shading_system=(False, "Open Shading Language is not carried"),
        rolling_shutter_type=("NONE", "the rolling shutter is not carried"),
    ),
    "SubsurfModifier": _table(
        use_adaptive_subdivision=(
            False, "adaptive subdivision is not carried, that for rendering is",
        ),
    ),
}  # fmt: skip
