/* What a file x_64.c includes first, before x.c: from then on numbers have 64 bits (number.h), and
 * functions that other files see have names of their own. */
#ifndef QS_IN_64_BITS_H
#define QS_IN_64_BITS_H

#define QS_BITS 64

#define qs_best                   qs_best_64
#define qs_best_workspace         qs_best_workspace_64
#define qs_bp                     qs_bp_64
#define qs_bp_graph_labels        qs_bp_graph_labels_64
#define qs_bp_graph_sweep         qs_bp_graph_sweep_64
#define qs_bp_grid_sweep          qs_bp_grid_sweep_64
#define qs_bp_send                qs_bp_send_64
#define qs_bp_workspace           qs_bp_workspace_64
#define qs_cut_begin              qs_cut_begin_64
#define qs_cut_is_quick           qs_cut_is_quick_64
#define qs_cut_run                qs_cut_run_64
#define qs_cut_source             qs_cut_source_64
#define qs_cut_spread             qs_cut_spread_64
#define qs_cut_spread_some        qs_cut_spread_some_64
#define qs_descent                qs_descent_64
#define qs_descent_workspace      qs_descent_workspace_64
#define qs_eliminate_above        qs_eliminate_above_64
#define qs_expansion              qs_expansion_64
#define qs_expansion_workspace    qs_expansion_workspace_64
#define qs_fuse                   qs_fuse_64
#define qs_fusion_count           qs_fusion_count_64
#define qs_fusion_fits            qs_fusion_fits_64
#define qs_fusion_moves           qs_fusion_moves_64
#define qs_fusion_moves_workspace qs_fusion_moves_workspace_64
#define qs_fusion_start           qs_fusion_start_64
#define qs_fusion_take            qs_fusion_take_64
#define qs_kicks_improve          qs_kicks_improve_64
#define qs_label_alone            qs_label_alone_64
#define qs_label_grid             qs_label_grid_64
#define qs_levels                 qs_levels_64
#define qs_levels_fit             qs_levels_fit_64
#define qs_levels_send            qs_levels_send_64
#define qs_levels_workspace       qs_levels_workspace_64
#define qs_message_pay            qs_message_pay_64
#define qs_message_scratch        qs_message_scratch_64
#define qs_message_send           qs_message_send_64
#define qs_messages_fit           qs_messages_fit_64
#define qs_min_cut                qs_min_cut_64
#define qs_min_cut_workspace      qs_min_cut_workspace_64
#define qs_mover_start            qs_mover_start_64
#define qs_mover_take             qs_mover_take_64
#define qs_probes_take_out        qs_probes_take_out_64
#define qs_propose_jump           qs_propose_jump_64
#define qs_reduce                 qs_reduce_64
#define qs_reduce_as              qs_reduce_as_64
#define qs_reduce_workspace       qs_reduce_workspace_64
#define qs_scale_choose           qs_scale_choose_64
#define qs_swap                   qs_swap_64
#define qs_swap_workspace         qs_swap_workspace_64
#define qs_times_in_range         qs_times_in_range_64
#define qs_trees_begin            qs_trees_begin_64
#define qs_trees_move             qs_trees_move_64
#define qs_trees_take             qs_trees_take_64
#define qs_trws                   qs_trws_64
#define qs_trws_graph_labels      qs_trws_graph_labels_64
#define qs_trws_graph_marginals   qs_trws_graph_marginals_64
#define qs_trws_graph_pass        qs_trws_graph_pass_64
#define qs_trws_graph_split       qs_trws_graph_split_64
#define qs_trws_grid_labels       qs_trws_grid_labels_64
#define qs_trws_grid_marginals    qs_trws_grid_marginals_64
#define qs_trws_grid_pass         qs_trws_grid_pass_64
#define qs_trws_iterate           qs_trws_iterate_64
#define qs_trws_marginal_numbers  qs_trws_marginal_numbers_64
#define qs_trws_marginals         qs_trws_marginals_64
#define qs_trws_messages          qs_trws_messages_64
#define qs_trws_padding           qs_trws_padding_64
#define qs_trws_scratch           qs_trws_scratch_64
#define qs_trws_split             qs_trws_split_64
#define qs_trws_visit_only        qs_trws_visit_only_64
#define qs_trws_watched           qs_trws_watched_64
#define qs_trws_workspace         qs_trws_workspace_64
#define qs_witness_split          qs_witness_split_64

#define qs_eliminate_above_in_parts     qs_eliminate_above_in_parts_64
#define qs_messages_and_moves           qs_messages_and_moves_64
#define qs_messages_and_moves_workspace qs_messages_and_moves_workspace_64

#endif
