#include "voxelserver/out/export/anvil/write_anvil.hpp"

#include <algorithm>
#include <fstream>
#include <system_error>

#include "common/thread/in_order.hpp"
#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "common/voxel/side_car.hpp"
#include "voxelserver/out/export/anvil/region_writer.hpp"
#include "voxelserver/out/export/anvil/section.hpp"
#include "voxelserver/out/export/core/journal.hpp"

namespace terravox::exports::anvil {

namespace fs = std::filesystem;
namespace {

using namespace anvil;

constexpr int kColumnsAlong = kRegionSize / voxel::kBoxSizeX;  // box columns along a region

/// One export.
class Export {
public:
    Export(Job& job, const AnvilOptions& options)
        : m_job(job),
          m_blocks(load_export_blocks(options)),
          m_place(find_place(without_sky(job))),
          m_title(make_title(job, options)) {}

    void write() {
        const std::string what = name_of_this();
        // Before anything is written: a rejected export leaves nothing behind.
        const voxel::BoxRange range = m_job.part.boxes();
        const ColumnBlock all{find_region(range.min.bx, 0), find_region(range.min.bz, 2),
                              find_region(range.max.bx - 1, 0) + 1,
                              find_region(range.max.bz - 1, 2) + 1};
        const Columns regions(
            all, 1, [this](const ColumnBlock& some) { return m_job.may_hold(find_boxes(some)); });
        const fs::path journal_file = m_job.out / kWorldJournal;
        refuse_other_worlds(journal_file, what);
        util::check_writable(m_job.out / "region" / "r.0.0.mca");
        fs::create_directories(m_job.out / "region");
        Journal journal(journal_file, what);
        m_job.count_voxels(journal.voxels_before());
        std::uint64_t columns = 0;
        for (std::size_t i = 0; i < regions.count(); ++i)
            columns += write_region_at(regions.at(i).bx, regions.at(i).bz, journal);
        m_job.meter.add(static_cast<std::uint64_t>(range.max.bx - range.min.bx) *
                            static_cast<std::uint64_t>(range.max.bz - range.min.bz) -
                        columns);
        if (m_job.voxels() == 0)
            refuse_nothing(journal);
        write_rest();
        journal.remove();
    }

private:
    struct PackedColumn {
        std::vector<PackedChunk> chunks;
        std::uint64_t voxels = 0;
    };
    using Region = std::pair<std::int32_t, std::int32_t>;  // rx, rz

    [[nodiscard]] static std::string make_title(const Job& job, const AnvilOptions& options) {
        if (!options.title.empty())
            return options.title;
        return job.world().title.empty() ? fs::weakly_canonical(job.out).filename().string()
                                         : job.world().title;
    }

    /// Everything that affects the files, in one line.
    [[nodiscard]] std::string name_of_this() const {
        const Part& part = m_job.part;
        std::string out =
            "anvil " + std::to_string(kDataVersion) + " level " + std::to_string(part.level);
        for (std::size_t a = 0; a < 3; ++a)
            out += " " + std::to_string(part.bounds.min[a]) + ".." +
                   std::to_string(part.bounds.max[a]);
        // Depends on the contents of the part, which may change where its bounds do not.
        out += " at " + std::to_string(m_place.offset[0]) + ',' +
               std::to_string(m_place.offset[1]) + ',' + std::to_string(m_place.offset[2]) +
               " from " + std::to_string(m_place.min_y) + " up " + std::to_string(m_place.height);
        out += m_job.colours == Colours::kTrue ? " true" : " material";
        std::string blocks;
        for (const ExportBlock& block : m_blocks.all())
            blocks += block.name + std::to_string(static_cast<int>(block.material)) + ",";
        out += " blocks " + std::to_string(m_blocks.all().size()) + "/" +
               std::to_string(fnv1a(blocks)) + " of " + m_job.name + ' ' + m_title;
        std::replace(out.begin(), out.end(), '\n', ' ');
        return out;
    }
    /// Ref: Fowler, Noll & Vo, FNV-1a.
    static std::uint64_t fnv1a(const std::string& text) noexcept {
        std::uint64_t hash = 0xcbf29ce484222325;
        for (const char c : text)
            hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
        return hash;
    }

    void refuse_other_worlds(const fs::path& journal, const std::string& what) const {
        std::string line;
        if (std::ifstream in(journal); in && std::getline(in, line) && line == what)
            return;
        check_new_world(m_job.out);
    }

    // Leaves nothing behind, so that another part may be written there.
    [[noreturn]] void refuse_nothing(Journal& journal) const {
        journal.remove();
        std::error_code ignored;
        fs::remove(m_job.out / "region", ignored);  // where they are empty
        fs::remove(m_job.out, ignored);
        throw util::Error("write a world for Minecraft to " + m_job.out.string() +
                          ": the part holds nothing solid" +
                          (m_job.holes().empty() ? "" : " but holes") + "; nothing was written");
    }

    // A world's bounds may be higher than its contents: a world that needs no data pack is
    // preferred where that is possible.
    [[nodiscard]] static Part without_sky(Job& job) {
        Part part = job.part;
        constexpr std::int32_t kUsualHeight = 384;
        if (part.bounds.max[1] - part.bounds.min[1] <= kUsualHeight - 2 * kSectionSize)
            return part;
        const voxel::BoxRange range = part.boxes();
        const Columns columns(to_block(range), kColumnsAlong,
                              [&](const ColumnBlock& block) { return job.may_hold(block); });
        std::int32_t top = part.bounds.min[1] + 1;
        thread::in_order(
            columns.count(), job.threads,
            [&](std::size_t i) {
                const Columns::At at = columns.at(i);
                const voxel::ColumnExtent extent = job.column(at.bx, at.bz);
                for (std::int32_t by = extent.by_end - 1; by >= extent.by_begin; --by)
                    if (const auto box = job.box(at.bx, by, at.bz); box && box->top() > 0)
                        return by * voxel::kBoxSizeY + box->top();
                return part.bounds.min[1];
            },
            [&](std::size_t, std::int32_t of_column) { top = std::max(top, of_column); });
        part.bounds.max[1] = std::min(part.bounds.max[1], top);
        return part;
    }

    /// Offsets are multiples of a region's size, so that box columns never lie in two.
    [[nodiscard]] std::int32_t find_region(std::int32_t box, std::size_t axis) const {
        return voxel::floor_div(box - m_place.offset[axis] / voxel::kBoxSizeX, kColumnsAlong);
    }

    /// Of columns of regions.
    [[nodiscard]] ColumnBlock find_boxes(const ColumnBlock& regions) const {
        const std::int32_t x = m_place.offset[0] / voxel::kBoxSizeX;
        const std::int32_t z = m_place.offset[2] / voxel::kBoxSizeZ;
        return {regions.min_bx * kColumnsAlong + x, regions.min_bz * kColumnsAlong + z,
                regions.max_bx * kColumnsAlong + x, regions.max_bz * kColumnsAlong + z};
    }

    /// @return (bx, bz) of the part's box columns in the region
    [[nodiscard]] std::vector<Region> columns_in(const Region& region) const {
        const voxel::BoxRange range = m_job.part.boxes();
        std::vector<Region> out;
        for (std::int32_t i = 0; i < kColumnsAlong * kColumnsAlong; ++i) {
            const std::int32_t bx = region.first * kColumnsAlong + i % kColumnsAlong +
                                    m_place.offset[0] / voxel::kBoxSizeX;
            const std::int32_t bz = region.second * kColumnsAlong + i / kColumnsAlong +
                                    m_place.offset[2] / voxel::kBoxSizeZ;
            if (bx >= range.min.bx && bx < range.max.bx && bz >= range.min.bz && bz < range.max.bz)
                out.emplace_back(bx, bz);
        }
        return out;
    }

    /// @return columns of boxes in it
    std::size_t write_region_at(std::int32_t rx, std::int32_t rz, Journal& journal) {
        const std::string name = "r." + std::to_string(rx) + "." + std::to_string(rz) + ".mca";
        const fs::path folder = m_job.out / "region";
        const auto columns = columns_in({rx, rz});
        std::error_code ignored;
        if (journal.has(name)) {
            m_job.meter.add(columns.size());
            if (fs::exists(folder / name, ignored))
                m_job.wrote(folder / name);
            return columns.size();
        }
        std::vector<PackedChunk> chunks;
        std::uint64_t voxels = 0;
        thread::in_order(
            columns.size(), m_job.threads,
            [&](std::size_t i) { return pack(columns[i].first, columns[i].second); },
            [&](std::size_t, PackedColumn column) {
                std::move(column.chunks.begin(), column.chunks.end(), std::back_inserter(chunks));
                voxels += column.voxels;
                m_job.meter.add();
            });
        if (!chunks.empty()) {
            write_region(folder, rx, rz, std::move(chunks));
            m_job.wrote(folder / name);
        }
        m_job.count_voxels(voxels);
        journal.add(name, voxels);
        return columns.size();
    }

    [[nodiscard]] PackedColumn pack(std::int32_t bx, std::int32_t bz) {
        PackedColumn out;
        BoxColumn column(m_job, m_place, bx, bz);
        if (column.empty())
            return out;
        ChunkWriter writer(m_blocks, m_place);
        SectionReader reader(m_blocks, m_job.part, m_job.colours);
        Compressor compressor;
        for (int cz = 0; cz < BoxColumn::kChunksAlong; ++cz)
            for (int cx = 0; cx < BoxColumn::kChunksAlong; ++cx) {
                const std::int32_t x = column.chunk_x() + cx;
                const std::int32_t z = column.chunk_z() + cz;
                const std::string nbt = writer.chunk(x, z, column.sections(cx, cz, reader));
                if (!nbt.empty())
                    out.chunks.push_back({x, z, compressor.zlib(nbt)});
            }
        out.voxels = writer.voxels();
        return out;
    }

    /// Writes everything except the regions; level.dat last, so that the game lists no incomplete
    /// world.
    void write_rest() {
        const auto put = [&](const fs::path& name, const std::string& bytes) {
            fs::create_directories((m_job.out / name).parent_path());
            util::write_file_atomically(m_job.out / name, bytes, util::Links::kReplace);
            m_job.wrote(m_job.out / name);
        };
        if (m_place.needs_pack())
            for (const auto& [name, text] : height_pack(m_place))
                put(fs::path("datapacks") / kPackName / name, text);
        voxel::SideCar car = voxel::make_side_car(m_job.world(), m_job.part.level, m_place.offset);
        car.blocks = m_blocks.meanings();
        voxel::write_side_car(m_job.out / "terravox.json", car);
        m_job.wrote(m_job.out / "terravox.json");
        put("level.dat",
            Compressor().gzip(level_dat(m_title, find_spawn(m_job, m_place), m_place)));
    }

    Job& m_job;
    const ExportBlocks m_blocks;
    const Place m_place;
    const std::string m_title;
};

}  // namespace

ExportBlocks load_export_blocks(const AnvilOptions& options) {
    const fs::path folder = options.blocks.empty() ? util::config_dir() / "blocks" : options.blocks;
    return ExportBlocks::load(folder, minecraft::BlockTable::load(folder));
}

void check_new_world(const fs::path& out) {
    std::error_code ignored;
    if (!fs::exists(out, ignored))
        return;
    const auto fail = [&](const std::string& why) {
        throw util::UsageError("write a world for Minecraft to " + out.string() + ": " + why +
                               "; allowed: a new or empty folder, or the same conversion cut off");
    };
    if (!fs::is_directory(out, ignored))
        fail("is a file");
    if (fs::exists(out / "level.dat", ignored))
        fail("holds a world");
    const fs::directory_iterator regions(out / "region", ignored);
    if (!ignored && regions != fs::directory_iterator())
        fail("holds regions of another world");
    for (const auto& entry : fs::directory_iterator(out)) {
        const fs::path name = entry.path().filename();
        if (name != kWorldJournal && name != "region")
            fail("holds " + name.string() + ", and no world");
    }
}

void write_anvil(Job& job, const AnvilOptions& options) {
    Export(job, options).write();
}

}  // namespace terravox::exports::anvil
