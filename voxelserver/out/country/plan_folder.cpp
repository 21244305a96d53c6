#include "voxelserver/out/country/plan_folder.hpp"

#include <array>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <system_error>

#include "common/util/error.hpp"
#include "common/voxel/bytes.hpp"
#include "common/voxel/file_identity.hpp"

namespace terravox::country {

namespace fs = std::filesystem;

PlanFolder::PlanFolder(const fs::path& folder) {
    std::error_code failed;
    m_path = fs::canonical(folder, failed);
    if (failed || !fs::is_directory(m_path, failed))
        throw util::UsageError("open the plan " + folder.string() +
                               ": there is no such folder; allowed: one that terravox country "
                               "plan has written");
    // A plan may be a stranger's.
    if (fs::is_symlink(scratch(), failed))
        throw util::UsageError("open the plan " + folder.string() + ": " + scratch().string() +
                               " is a symbolic link, and folders behind it would be removed; "
                               "allowed: a folder, or none");
}

fs::path PlanFolder::shard(int number) const {
    std::array<char, 16> name{};
    std::snprintf(name.data(), name.size(), "%05d.tvx", number);
    return m_path / "shards" / name.data();
}

fs::path PlanFolder::of_task(int number, const char* ending) const {
    std::array<char, 24> name{};
    std::snprintf(name.data(), name.size(), "%05d.%s", number, ending);
    return m_path / "tasks" / name.data();
}

fs::path PlanFolder::lock(int number) const {
    return of_task(number, "lock");
}

fs::path PlanFolder::record(int number) const {
    return of_task(number, "json");
}

fs::path PlanFolder::log(int number) const {
    return of_task(number, "txt");
}

void PlanFolder::make_folders() const {
    for (const char* name : {"shards", "tasks"}) {
        std::error_code failed;
        fs::create_directories(m_path / name, failed);
        if (failed)
            throw util::Error("make the folder " + (m_path / name).string() + ": " +
                              failed.message());
    }
}

std::string fingerprint_of_known(std::string_view bytes) {
    voxel::ByteWriter out;
    out.add(std::string(bytes));
    return voxel::hex_of(out.fingerprint());
}

bool has_known_squares_of(const PlanFolder& folder, const Plan& plan) {
    std::ifstream in(folder.known_squares(), std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    return in && fingerprint_of_known(bytes) == plan.known_squares;
}

}  // namespace terravox::country
