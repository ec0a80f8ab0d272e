/* The parts of a .qpf: what its writer and its reader must agree on (docs/FORMAT.md, section 4). */
#ifndef QS_CERTIFICATE_LAYOUT_H
#define QS_CERTIFICATE_LAYOUT_H

#define QS_MAGIC_QPF  "\x89QPF\r\n\x1a\n"
#define QS_QPF_CHUNKS "PROBBESTSTGS"

enum {
    QS_QPF_CHUNK_COUNT = 3,
    QS_QPF_FIELDS = 24, /* bytes of the header's own fields that are in use */
    QS_BEST_HEAD = 4,
    QS_STAGE_HEAD = 16,
    QS_SCALE_MOST = 1 << 30,
    QS_STAGES_MOST = 4096 /* so that no small file asks for long work */
};

/* So that no sum of costs and shares leaves 2^60: of costs times the scale, of slots, of a share
 * as often as there are slots. */
#define QS_MOST_COSTS  ((uint64_t)1 << 59)
#define QS_MOST_SLOTS  ((uint64_t)1 << 27)
#define QS_MOST_SHARES ((uint64_t)1 << 58)
#define QS_MOST_SHARE  ((int64_t)1 << 60) /* that a writer can make smaller */

/* What a stage has. Parts, solved by tables or by search, stand alone. */
enum { QS_STAGE_SPLITS = 1, QS_STAGE_LEAVES = 2, QS_STAGE_PARTS = 4, QS_STAGE_SEARCHES = 8 };

#endif
