#include "voxelserver/make/worlds/minecraft/level_dat.hpp"

#include "common/util/error.hpp"
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
            level.version = utf8_of(in.string());
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
            level.name = utf8_of(in.string());
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
        throw util::Error("read " + origin + ": " + e.what());
    }
}

}  // namespace terravox::minecraft
