#include "voxelserver/out/archive/split.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <string_view>
#include <system_error>

#include "common/voxel/archive/archive_reader.hpp"

namespace terravox::archive_tools {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPartEnding = ".part";
constexpr std::size_t kDigits = 4;

/// Longer numbers are larger ones.
bool is_before(const fs::path& a, const fs::path& b) {
    const std::string x = a.filename().string();
    const std::string y = b.filename().string();
    return x.size() != y.size() ? x.size() < y.size() : x < y;
}

}  // namespace

void append_stretch(voxel::archive::ByteSource& archive, std::uint64_t begin, std::uint64_t bytes,
                    util::AtomicFile& to) {
    constexpr std::uint64_t kBlock = std::uint64_t{4} << 20;
    std::vector<std::byte> room;
    for (std::uint64_t done = 0; done < bytes;) {
        const std::uint64_t size = std::min(bytes - done, kBlock);
        to.append(archive.read(begin + done, static_cast<std::size_t>(size), room));
        done += size;
    }
}

std::string part_name(const std::string& stem, std::size_t number, std::size_t of) {
    const std::size_t digits = std::max(kDigits, std::to_string(of).size());
    return fmt::format("{}-{:0{}}{}", stem, number, digits, kPartEnding);
}

std::vector<FilePart> write_parts(voxel::archive::ByteSource& archive, std::uint64_t bytes,
                                  const std::string& stem, const fs::path& folder,
                                  std::uint64_t max_bytes) {
    const std::size_t count =
        static_cast<std::size_t>(bytes / max_bytes + (bytes % max_bytes == 0 ? 0 : 1));
    std::vector<FilePart> parts;
    // All or none: of an archive that cannot be read to its end, some parts are of no use.
    std::vector<std::unique_ptr<util::AtomicFile>> files;
    for (std::uint64_t begin = 0; begin < bytes; begin += parts.back().bytes) {
        parts.push_back(
            {part_name(stem, parts.size() + 1, count), std::min(bytes - begin, max_bytes)});
        files.push_back(std::make_unique<util::AtomicFile>(folder / parts.back().name));
        append_stretch(archive, begin, parts.back().bytes, *files.back());
        // There may be more parts than a process has descriptors.
        files.back()->close();
    }
    for (const auto& file : files)
        file->commit();
    return parts;
}

std::vector<FilePart> split(const fs::path& file, const fs::path& folder, std::uint64_t max_bytes) {
    const auto source = voxel::archive::file_source(file);
    const std::uint64_t bytes = voxel::archive::ArchiveIndex(*source).header().file_bytes;
    if (bytes <= max_bytes)
        return {{file.filename().string(), bytes}};
    return write_parts(*source, bytes, file.stem().string(), folder, max_bytes);
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

std::vector<fs::path> parts_in(const fs::path& folder, const std::string& stem) {
    std::vector<fs::path> out;
    std::error_code failed;
    for (const auto& entry : fs::directory_iterator(folder, failed))
        if (is_part(entry.path().filename().string(), stem))
            out.push_back(entry.path());
    std::sort(out.begin(), out.end(), is_before);
    return out;
}

std::vector<fs::path> in_order_of_numbers(std::vector<fs::path> files) {
    if (files.empty())
        return files;
    const std::string first = files.front().filename().string();
    const std::string stem = first.substr(0, std::min(first.rfind('-'), first.size()));
    const bool are_parts = std::all_of(files.begin(), files.end(), [&](const fs::path& file) {
        return file.parent_path() == files.front().parent_path() &&
               is_part(file.filename().string(), stem);
    });
    if (are_parts)
        std::sort(files.begin(), files.end(), is_before);
    return files;
}

}  // namespace terravox::archive_tools
