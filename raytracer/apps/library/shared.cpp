// The shared library's own source: everything else comes from terravox_library.
#include <terravox/terravox.hpp>
