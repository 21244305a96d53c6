#include "voxelserver/archive/split.hpp"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <string_view>
#include <system_error>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"

namespace terravox::archive_tools {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPartEnding = ".part";
constexpr std::size_t kDigits = 4;

std::string part_name(const std::string& stem, std::size_t number) {
    char digits[24];
    std::snprintf(digits, sizeof digits, "-%04zu", number);
    return stem + digits + std::string(kPartEnding);
}

bool is_part(const std::string& name, const std::string& stem) {
    const std::string begins = stem + "-";
    if (name.size() < begins.size() + kDigits + kPartEnding.size() || !name.starts_with(begins) ||
        !name.ends_with(kPartEnding))
        return false;
    const std::string_view number = std::string_view(name).substr(
        begins.size(), name.size() - begins.size() - kPartEnding.size());
    return std::all_of(number.begin(), number.end(), [](char c) { return c >= '0' && c <= '9'; });
}

// Copies the next bytes of an archive into a file of its own.
void write_part(std::ifstream& in, const fs::path& to, std::uint64_t bytes) {
    constexpr std::size_t kBlock = std::size_t{1} << 20;
    util::AtomicFile file(to);
    std::ofstream out(file.temporary_path(), std::ios::binary);
    std::string block(kBlock, '\0');
    for (std::uint64_t left = bytes; left > 0;) {
        const auto size = static_cast<std::streamsize>(std::min<std::uint64_t>(left, kBlock));
        if (!in.read(block.data(), size))
            throw util::Error("split the archive: it cannot be read to its end");
        if (!out.write(block.data(), size))
            break;
        left -= static_cast<std::uint64_t>(size);
    }
    out.close();
    if (!out)
        throw util::Error("write " + to.string() + ": the disk may be full");
    file.commit();
}

}  // namespace

std::vector<FilePart> split(const fs::path& file, const fs::path& folder, std::uint64_t max_bytes) {
    const std::uint64_t bytes = fs::file_size(file);
    if (bytes <= max_bytes)
        return {{file.filename().string(), bytes}};
    std::ifstream in(file, std::ios::binary);
    if (!in)
        throw util::Error("split " + file.string() + ": it cannot be read");
    std::vector<FilePart> parts;
    for (std::uint64_t left = bytes; left > 0;) {
        const std::uint64_t size = std::min(left, max_bytes);
        parts.push_back({part_name(file.stem().string(), parts.size() + 1), size});
        write_part(in, folder / parts.back().name, size);
        left -= size;
    }
    return parts;
}

std::vector<fs::path> parts_in(const fs::path& folder, const std::string& stem) {
    std::vector<fs::path> out;
    std::error_code failed;
    for (const auto& entry : fs::directory_iterator(folder, failed))
        if (is_part(entry.path().filename().string(), stem))
            out.push_back(entry.path());
    // Longer numbers are larger ones.
    std::sort(out.begin(), out.end(), [](const fs::path& a, const fs::path& b) {
        const std::string x = a.filename().string();
        const std::string y = b.filename().string();
        return x.size() != y.size() ? x.size() < y.size() : x < y;
    });
    return out;
}

}  // namespace terravox::archive_tools
