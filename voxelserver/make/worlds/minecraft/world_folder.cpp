#include "voxelserver/make/worlds/minecraft/world_folder.hpp"

#include <algorithm>
#include <set>
#include <tuple>

#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "voxelserver/make/worlds/minecraft/inflate.hpp"
#include "voxelserver/make/worlds/minecraft/nbt.hpp"

namespace terravox::minecraft {
namespace {

bool whole_number(NbtType type) noexcept {
    return type >= NbtType::kByte && type <= NbtType::kLong;
}

// Spawn as [x, y, z], as newer versions store it within a compound of its own.
void read_spawn(NbtReader& in, LevelDat& level) {
    NbtField field;
    while (in.next(field)) {
        if (field.name == "pos" && field.type == NbtType::kInts) {
            const NbtInts at = in.int_array();
            if (at.count != 3)
                continue;
            auto& spawn = level.spawn.emplace();
            for (std::size_t a = 0; a < 3; ++a)
                spawn[a] = static_cast<std::int32_t>(at[a]);
        } else {
            in.skip(field.type);
        }
    }
}

void read_version(NbtReader& in, LevelDat& level) {
    NbtField field;
    while (in.next(field)) {
        if (field.name == "Name" && field.type == NbtType::kString)
            level.version = to_utf8(in.string());
        else if (field.name == "Id" && whole_number(field.type))
            level.data_version = level.data_version.value_or(in.integer(field.type));
        else
            in.skip(field.type);
    }
}

void read_data(NbtReader& in, LevelDat& level) {
    constexpr std::string_view kSpawn[] = {"SpawnX", "SpawnY", "SpawnZ"};
    std::array<std::int64_t, 3> spawn{};
    int spawn_fields = 0;
    NbtField field;
    while (in.next(field)) {
        if (field.name == "LevelName" && field.type == NbtType::kString) {
            level.name = to_utf8(in.string());
        } else if (field.name == "DataVersion" && whole_number(field.type)) {
            level.data_version = in.integer(field.type);
        } else if ((field.name == "RandomSeed" || field.name == "seed") &&
                   whole_number(field.type)) {
            level.seed = in.integer(field.type);
        } else if (field.name == "Version" && field.type == NbtType::kCompound) {
            read_version(in, level);
        } else if (field.name == "spawn" && field.type == NbtType::kCompound) {
            read_spawn(in, level);
        } else if (field.name == "WorldGenSettings" && field.type == NbtType::kCompound) {
            NbtField setting;
            while (in.next(setting)) {
                if (setting.name == "seed" && whole_number(setting.type))
                    level.seed = in.integer(setting.type);
                else
                    in.skip(setting.type);
            }
        } else {
            bool taken = false;
            for (std::size_t a = 0; a < 3; ++a)
                if (field.name == kSpawn[a] && whole_number(field.type)) {
                    spawn[a] = in.integer(field.type);
                    ++spawn_fields;
                    taken = true;
                }
            if (!taken)
                in.skip(field.type);
        }
    }
    if (spawn_fields == 3)
        level.spawn = spawn;
}

}  // namespace

LevelDat read_level_dat(std::span<const std::uint8_t> file, const std::string& origin) {
    try {
        Inflater inflater;
        NbtReader in(inflater.unpack(guess_compression(file), file));
        LevelDat level;
        in.enter_root();
        NbtField field;
        while (in.next(field)) {
            if (field.name == "Data" && field.type == NbtType::kCompound)
                read_data(in, level);
            else
                in.skip(field.type);
        }
        return level;
    } catch (const util::Error& e) {
        throw util::Error("read {}: {}", origin, e.what());
    }
}

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kLevelFile = "level.dat";
constexpr std::string_view kSideCarFile = "terravox.json";
constexpr std::size_t kMaxSmallFileBytes = std::size_t{16} << 20;  // level.dat and the side-car

int find_depth(std::string_view folder) noexcept {
    return folder.empty() ? 0 : 1 + static_cast<int>(std::count(folder.begin(), folder.end(), '/'));
}

bool within(std::string_view path, std::string_view folder) noexcept {
    return folder.empty() ||
           (path.size() > folder.size() && path.starts_with(folder) && path[folder.size()] == '/');
}

/// The shallowest of some folders.
/// @throws UsageError when there are several
std::string shallowest(const std::set<std::string>& folders, const fs::path& path) {
    int least = find_depth(*folders.begin());
    for (const std::string& folder : folders)
        least = std::min(least, find_depth(folder));
    std::vector<std::string> there;
    for (const std::string& folder : folders)
        if (find_depth(folder) == least)
            there.push_back(folder);
    if (there.size() == 1)
        return there.front();
    constexpr std::size_t kNamed = 5;
    std::string names;
    for (std::size_t i = 0; i < std::min(kNamed, there.size()); ++i)
        names += (i == 0 ? "" : ", ") + there[i];
    throw util::UsageError("open the Minecraft world {}: it holds {} worlds ({}{}); allowed: one",
                           path.string(), there.size(), names,
                           there.size() > kNamed ? ", ..." : "");
}

fs::path folder_when_level_file(const fs::path& path) {
    std::error_code ignored;
    if (path.filename() != kLevelFile || !fs::is_regular_file(path, ignored))
        return path;
    return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

}  // namespace

WorldFolder::WorldFolder(const fs::path& path, std::size_t cache_bytes)
    : m_path(folder_when_level_file(path)), m_source(open_source(m_path, cache_bytes)) {
    for (const std::string& line : m_source->refused())
        m_damage.push_back(line);
    std::error_code ignored;
    const auto& entries = m_source->entries();
    // A single file that is not a ZIP file is a source by itself.
    if (fs::is_regular_file(m_path, ignored) && entries.size() == 1 &&
        entries.front().path == m_path.filename().string()) {
        add_single_file();
    } else {
        find_root();
        read_level();
        collect();
        if (m_dimensions.empty()) {
            refuse_bedrock();
            refuse_linear();
        }
    }
    std::stable_sort(m_dimensions.begin(), m_dimensions.end(),
                     [](const DimensionFolder& a, const DimensionFolder& b) {
                         return std::pair(a.name != "overworld", a.name) <
                                std::pair(b.name != "overworld", b.name);
                     });
}

void WorldFolder::add_single_file() {
    const std::string& name = m_source->entries().front().path;
    ChunkFile file;
    file.placed = false;
    if (const auto placed = placed_file(name); placed && placed->refused.empty()) {
        file.kind = placed->kind;
        file.x = placed->x;
        file.z = placed->z;
        file.placed = true;
    } else if (!name.ends_with(".mca") && !name.ends_with(".mcr"))
        file.kind = FileKind::kChunk;
    else
        file.kind = name.ends_with(".mca") ? FileKind::kAnvil : FileKind::kMcRegion;
    m_dimensions.push_back({"overworld", "", {file}, {}});
}

// The folder of level.dat; without any, that of the shallowest chunks. Folders like `entities` hold
// files named as regions, too, but deeper.
void WorldFolder::find_root() {
    std::set<std::string> with_level;
    std::set<std::string> with_chunks;
    for (const FileSource::Entry& entry : m_source->entries()) {
        if (to_name(entry.path) == kLevelFile)
            with_level.emplace(find_folder(entry.path));
        if (const auto placed = placed_file(entry.path))
            with_chunks.emplace(placed->root);
    }
    if (with_level.empty() && with_chunks.empty()) {
        refuse_bedrock();
        throw util::UsageError(
            "open the Minecraft world {}: no level.dat and no chunks are there; allowed: a world's "
            "folder or ZIP file, .mca, .mcr or c.X.Z.dat files",
            m_path.string());
    }
    m_root = shallowest(with_level.empty() ? with_chunks : with_level, m_path);
}

void WorldFolder::refuse_bedrock() const {
    for (const FileSource::Entry& entry : m_source->entries())
        if (is_bedrock_file((m_path / entry.path).lexically_normal().generic_string()))
            throw util::UsageError(
                "open the Minecraft world {}: it is of the Bedrock edition (or Education), which "
                "keeps its chunks in a database ({}); allowed: worlds of the Java edition; convert "
                "it to one first, for example with Chunker or Amulet",
                m_path.string(), entry.path);
}

void WorldFolder::refuse_linear() const {
    for (const FileSource::Entry& entry : m_source->entries())
        if (entry.path.ends_with(".linear"))
            throw util::UsageError(
                "open the Minecraft world {}: its regions are of the linear format ({}), which "
                "servers use and the game does not; allowed: .mca and .mcr; convert them first",
                m_path.string(), entry.path);
}

DimensionFolder& WorldFolder::dimension_at(std::string_view folder) {
    const auto found = std::find_if(m_dimensions.begin(), m_dimensions.end(),
                                    [&](const DimensionFolder& d) { return d.folder == folder; });
    if (found != m_dimensions.end())
        return *found;
    m_dimensions.push_back({dimension_name(folder), std::string(folder), {}, {}});
    return m_dimensions.back();
}

// Since 26.1 the game keeps every dimension in `dimensions`, and moves there what it finds at the
// old places. A world that has a dimension at both was put together by other means: what the
// version of level.dat reads counts.
void WorldFolder::pass_over_second_places() {
    constexpr std::int64_t kFirstInDimensions = 4774;  // 26.1 Snapshot 6
    // Before 1.9 there were no versions of data.
    const bool old_counts = m_level && m_level->data_version.value_or(0) < kFirstInDimensions;
    const auto counts = [&](const DimensionFolder& d) {
        return d.folder.starts_with("dimensions/") != old_counts;
    };
    std::stable_partition(m_dimensions.begin(), m_dimensions.end(), counts);
    std::vector<DimensionFolder> kept;
    for (DimensionFolder& dimension : m_dimensions) {
        const auto first = std::find_if(kept.begin(), kept.end(), [&](const DimensionFolder& d) {
            return d.name == dimension.name;
        });
        if (first == kept.end()) {
            kept.push_back(std::move(dimension));
            continue;
        }
        const char* const game = old_counts ? "of level.dat, before 26.1," : "since 26.1";
        first->notes.push_back(joined(dimension.folder, "region") + ": passed over, the game " +
                               game + " reads " + joined(first->folder, "region"));
        util::log_warn("{}: {}", m_path.string(), first->notes.back());
    }
    m_dimensions = std::move(kept);
}

void WorldFolder::collect() {
    const auto& entries = m_source->entries();
    for (std::size_t i = 0; i < entries.size(); ++i) {
        if (!within(entries[i].path, m_root))
            continue;
        const auto placed = placed_file(
            std::string_view(entries[i].path).substr(m_root.empty() ? 0 : m_root.size() + 1));
        if (!placed || !placed->root.empty())
            continue;
        DimensionFolder& dimension = dimension_at(placed->dimension);
        if (!placed->refused.empty())
            dimension.notes.push_back(entries[i].path + ": " + std::string(placed->refused));
        else
            dimension.files.push_back({i, placed->kind, placed->x, placed->z, true});
    }
    // A world that the game has upgraded keeps its old files. The newest kind counts: .mca, then
    // .mcr, region by region; Alpha chunks only where there is no region at all.
    for (DimensionFolder& dimension : m_dimensions) {
        auto& files = dimension.files;
        std::stable_sort(files.begin(), files.end(), [](const ChunkFile& a, const ChunkFile& b) {
            return std::tuple(a.kind == FileKind::kAlpha, a.x, a.z, a.kind) <
                   std::tuple(b.kind == FileKind::kAlpha, b.x, b.z, b.kind);
        });
        std::vector<ChunkFile> kept;
        for (const ChunkFile& file : files) {
            const bool same = !kept.empty() && kept.back().x == file.x && kept.back().z == file.z;
            const bool older = !kept.empty() && kept.front().kind != FileKind::kAlpha &&
                               file.kind == FileKind::kAlpha;
            if (same || older)
                dimension.notes.push_back(entries[file.entry].path + ": passed over, " +
                                          entries[(same ? kept.back() : kept.front()).entry].path +
                                          " is newer");
            else
                kept.push_back(file);
        }
        files = std::move(kept);
    }
    pass_over_second_places();
}

void WorldFolder::read_level() {
    if (const auto entry = m_source->find(joined(m_root, kLevelFile))) {
        const std::string& name = m_source->entries()[*entry].path;
        try {
            m_level = read_level_dat(m_source->whole(*entry, kMaxSmallFileBytes), name);
        } catch (const util::Error& e) {
            m_damage.push_back(e.what());
        }
    }
    if (const auto entry = m_source->find(joined(m_root, kSideCarFile))) {
        const auto bytes = m_source->whole(*entry, kMaxSmallFileBytes);
        m_side_car.emplace(bytes.begin(), bytes.end());
    }
}

std::string WorldFolder::title() const {
    if (m_level && !m_level->name.empty())
        return m_level->name;
    if (!m_root.empty())
        return std::string(to_name(m_root));
    const fs::path whole = fs::absolute(m_path).lexically_normal();
    const fs::path last = whole.has_filename() ? whole : whole.parent_path();
    return (fs::is_directory(m_path) ? last.filename() : last.stem()).string();
}

const DimensionFolder& WorldFolder::dimension(std::string_view name) const {
    std::string names;
    for (const DimensionFolder& dimension : m_dimensions) {
        if (dimension.name == name)
            return dimension;
        names += (names.empty() ? "" : ", ") + dimension.name;
    }
    throw util::UsageError("open the Minecraft world {}: no dimension '{}'; allowed: {}",
                           m_path.string(), name, names.empty() ? "none is there" : names);
}

}  // namespace terravox::minecraft
