#include "tests/fuzz/fuzz.hpp"

#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "tests/common/temporary_folder.hpp"

namespace terravox::fuzz {

void expect(bool holds, const char* what) {
    if (holds)
        return;
    std::fprintf(stderr, "not true: %s\n", what);
    std::abort();
}

std::filesystem::path as_file(Input input, const std::string& name) {
    static const test::TemporaryFolder folder;
    const std::filesystem::path path = folder.path() / name;
    std::ofstream out(path, std::ios::binary | std::ios::trunc);
    out.write(reinterpret_cast<const char*>(input.data()),
              static_cast<std::streamsize>(input.size()));
    out.close();
    expect(out.good(), "the temporary folder takes a file");
    return path;
}

}  // namespace terravox::fuzz
