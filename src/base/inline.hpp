#pragma once

/// Forces inlining of the innermost kernel functions: there a call costs more than its work, and passing a Pack through
/// memory twice as much.
#define PLIANT_INLINE [[gnu::always_inline]] inline
