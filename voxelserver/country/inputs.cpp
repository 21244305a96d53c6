#include "voxelserver/country/inputs.hpp"

#include <algorithm>
#include <map>
#include <mutex>
#include <optional>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "common/util/version.hpp"
#include "common/voxel/file_identity.hpp"
#include "voxelserver/imagery/image_identity.hpp"
#include "voxelserver/imagery/orthophoto_files.hpp"
#include "voxelserver/pointcloud/formats/open.hpp"
#include "voxelserver/store/grabber_store.hpp"
#include "voxelserver/voxelize/points/lidar_files.hpp"
#include "voxelserver/voxelize/world/input_fingerprints.hpp"
#include "voxelserver/worlds/lidar/lidar_inputs.hpp"
#include "voxelserver/worlds/lidar/lidar_kind.hpp"

namespace terravox::country {
namespace {

namespace fs = std::filesystem;

/// All files that the options name, also those that cannot be opened.
voxelize::LidarWorldOptions options_of(const worlds::WorldOptions& world) {
    for (const std::string& input : world.inputs)
        if (!worlds::is_store(input) && !worlds::is_lidar(input))
            throw util::UsageError("plan the country: " + input +
                                   "; allowed: " + std::string(worlds::kLidarInputs) +
                                   ", folders of them, or the grabber's store");
    return worlds::lidar_world_options(world);
}

std::string identity_of(const fs::path& file) {
    return voxel::hex_of(voxel::file_identity(file, "point cloud"));
}

std::uint64_t size_of(const fs::path& file) {
    std::error_code failed;
    const auto size = fs::file_size(file, failed);
    return failed ? 0 : size;
}

/// @return why the file cannot be opened; empty: it can
std::string look_at(PlannedFile& file) {
    try {
        const auto source = pointcloud::open_point_source(file.file);
        constexpr std::size_t kFew = 16;
        (void)source->sample(kFew);
        file.points = source->info().point_count;
        file.bytes = size_of(file.file);
        file.identity = identity_of(file.file);
        return "";
    } catch (const util::Error& e) {
        return e.what();
    }
}

std::vector<PlannedFile> images_of(const voxelize::LidarWorldOptions& options) {
    std::vector<PlannedFile> out;
    if (options.orthophotos.empty())
        return out;
    for (const fs::path& file : imagery::orthophoto_files(options.orthophotos))
        out.push_back({file, size_of(file), 0, voxel::hex_of(imagery::image_identity(file))});
    return out;
}

void add_missing_of_store(const std::string& folder, std::vector<MissingSquare>& missing) {
    for (const store::StoredSquare& square : store::read_grabber_store(folder).squares)
        if (square.state != store::StoredState::kFetched)
            missing.push_back({square.name, square.error.empty() ? std::string("the store says: ") +
                                                                       store::name_of(square.state)
                                                                 : square.error});
}

using Named = std::map<std::string, const PlannedFile*>;

Named by_name(const std::vector<PlannedFile>& files) {
    Named out;
    for (const PlannedFile& file : files)
        out.emplace(file.file.lexically_normal().string(), &file);
    return out;
}

/// @param now files that are there
/// @param identity of a file that is there
template <class Identity>
void compare(const std::vector<PlannedFile>& then, const std::vector<fs::path>& now,
             const Identity& identity, std::vector<std::string>& out) {
    Named planned = by_name(then);
    for (const fs::path& file : now) {
        const auto found = planned.find(file.lexically_normal().string());
        if (found == planned.end()) {
            out.push_back(file.string() + " is new");
            continue;
        }
        try {
            if (identity(file) != found->second->identity)
                out.push_back(file.string() + " has changed");
        } catch (const util::Error& e) {
            out.emplace_back(e.what());
        }
        planned.erase(found);
    }
    for (const auto& [name, file] : planned)
        out.push_back(file->file.string() + " is gone");
}

}  // namespace

Inputs look_at_inputs(const worlds::WorldOptions& world) {
    const voxelize::LidarWorldOptions options = options_of(world);
    Inputs out;
    for (const fs::path& file : voxelize::lidar_files(options))
        out.squares.push_back({file, 0, 0, ""});
    std::vector<std::string> reasons(out.squares.size());
    thread::parallel_for(out.squares.size(), world.threads,
                         [&](std::size_t i) { reasons[i] = look_at(out.squares[i]); });
    std::vector<PlannedFile> whole;
    for (std::size_t i = 0; i < reasons.size(); ++i) {
        if (reasons[i].empty()) {
            whole.push_back(std::move(out.squares[i]));
            continue;
        }
        const fs::path& file = out.squares[i].file;
        out.missing.push_back({file.stem().string(), reasons[i]});
        out.left_out.push_back(file);
    }
    out.squares = std::move(whole);
    if (out.squares.empty())
        throw util::UsageError("plan the country: no file can be opened: " +
                               out.missing.front().reason);
    for (const std::string& input : world.inputs)
        if (worlds::is_store(input))
            add_missing_of_store(input, out.missing);
    std::sort(out.missing.begin(), out.missing.end(),
              [](const MissingSquare& a, const MissingSquare& b) { return a.name < b.name; });
    out.images = images_of(options);
    return out;
}

std::vector<std::string> changes_since(const Plan& plan) {
    std::vector<std::string> out;
    std::optional<voxelize::LidarWorldOptions> options;
    std::vector<fs::path> files;
    std::vector<fs::path> images;
    try {
        options = options_of(plan.world);
        files = voxelize::lidar_files(*options);
        if (!options->orthophotos.empty())
            images = imagery::orthophoto_files(options->orthophotos);
    } catch (const util::Error& e) {
        return {e.what()};
    }
    compare(plan.squares, files, identity_of, out);
    compare(
        plan.images, images,
        [](const fs::path& file) { return voxel::hex_of(imagery::image_identity(file)); }, out);
    return out;
}

void check_current(const Plan& plan, const std::string& attempt) {
    if (plan.program != kVersion || plan.box_recipe != voxelize::kBoxRecipe)
        throw util::Error(attempt + ": the plan was made by version " + plan.program + " (boxes " +
                          std::to_string(plan.box_recipe) + "), this program is version " +
                          kVersion + " (boxes " + std::to_string(voxelize::kBoxRecipe) +
                          "); allowed: the same");
    const std::vector<std::string> changes = changes_since(plan);
    if (changes.empty())
        return;
    std::string more;
    if (changes.size() > 1)
        more = ", and " + std::to_string(changes.size() - 1) + " more";
    throw util::Error(attempt + ": the data have changed since the plan was made: " +
                      changes.front() + more + "; plan again");
}

}  // namespace terravox::country
