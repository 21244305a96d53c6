// Compiled only with Catch2 2, whose main() is a macro; Catch2 3 brings it as a library.
#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>
