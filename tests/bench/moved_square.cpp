#include "tests/bench/moved_square.hpp"

#include <array>
#include <cstring>
#include <fstream>

#include "common/util/error.hpp"

namespace terravox::bench {
namespace {

// Doubles of the public header block, bytes from the start of the file. Ref: ASPRS, "LAS
// Specification", versions 1.2 to 1.4.
constexpr std::array<std::streamoff, 3> kEast = {155, 179, 187};   // offset, maximum, minimum x
constexpr std::array<std::streamoff, 3> kNorth = {163, 195, 203};  // the same of y

void shift(std::fstream& file, std::streamoff at, double by) {
    std::array<char, sizeof(double)> bytes{};
    file.seekg(at).read(bytes.data(), bytes.size());
    double value = 0;
    std::memcpy(&value, bytes.data(), sizeof value);
    value += by;
    std::memcpy(bytes.data(), &value, sizeof value);
    file.seekp(at).write(bytes.data(), bytes.size());
}

}  // namespace

void copy_moved(const std::filesystem::path& from, const std::filesystem::path& to, double east_m,
                double north_m) {
    std::error_code failed;
    if (std::filesystem::exists(to) &&
        std::filesystem::file_size(to) == std::filesystem::file_size(from))
        return;
    std::filesystem::copy_file(from, to, std::filesystem::copy_options::overwrite_existing, failed);
    if (failed)
        throw util::Error("copy " + from.string() + " to " + to.string() + ": " + failed.message());
    std::fstream file(to, std::ios::binary | std::ios::in | std::ios::out);
    std::array<char, 4> magic{};
    file.read(magic.data(), magic.size());
    if (!file || std::memcmp(magic.data(), "LASF", magic.size()) != 0)
        throw util::Error("move " + from.string() + ": not a LAS file");
    for (const std::streamoff at : kEast)
        shift(file, at, east_m);
    for (const std::streamoff at : kNorth)
        shift(file, at, north_m);
    if (!file.flush())
        throw util::Error("write " + to.string() + ": the header could not be changed");
}

}  // namespace terravox::bench
