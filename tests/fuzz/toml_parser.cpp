// toml++ itself, compiled with the sanitizers and libFuzzer's counters. The system's library has
// neither: a fault in it would stay unseen, and libFuzzer would not learn which input leads where.
// Its assertions are off, as there: some of them do not hold (3.3.0: "[," is no key, and is refused
// as such, but after an assertion that it is one).
#define TOML_ASSERT(expression) static_cast<void>(0)
#define TOML_IMPLEMENTATION
#include <toml++/toml.h>
