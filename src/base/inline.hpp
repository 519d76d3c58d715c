#pragma once

/// For the leaves of the kernels: a call there costs more than the work, and a Pack passed through memory twice as
/// much.
#define PLIANT_INLINE [[gnu::always_inline]] inline
