// TOML as such: what every file of settings goes through.
#include "common/util/toml_file.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace terravox::fuzz {

void run(Input input) {
    (void)util::parse_toml(as_text(input), "the input", [](const std::string& what) {
        throw util::UsageError("read the input: " + what);
    });
}

}  // namespace terravox::fuzz
