#include "raytracer/farm/checkpoint/checkpoint.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <numeric>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "common/util/log.hpp"
#include "common/util/numbers.hpp"
#include "raytracer/core/tiles/tile_codec.hpp"

namespace terravox::farm {
namespace {

/// Number of parts by which a row is shifted against the one above. It is close to the golden
/// section of their number, so that no direction in the picture favours a part, and coprime to it,
/// so that all shifts occur.
std::uint32_t to_shift(std::uint32_t count) noexcept {
    auto shift = static_cast<std::uint32_t>(static_cast<double>(count) * 0.6180339887498949);
    while (shift > 1 && std::gcd(shift, count) != 1)
        --shift;
    return shift > 0 ? shift : 1;
}

}  // namespace

std::optional<Part> Part::parse(const std::string& text) {
    const auto part = util::parse_part<std::uint32_t>(text);
    if (!part || part->second > kMaxParts)
        return std::nullopt;
    return Part{part->first, part->second};
}

bool Part::has(std::uint32_t column, std::uint32_t row) const noexcept {
    return (column + std::uint64_t{row} * to_shift(count)) % count == index - 1;
}

namespace {

constexpr std::chrono::seconds kFlushPeriod{1};

const std::string kAttempt = "write the checkpoint";

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& why) {
    throw util::Error(kAttempt + " " + path.string() + ": " + why);
}

/// Opens and locks.
OpenFile locked(const std::filesystem::path& path) {
    while (true) {
        OpenFile file(path, O_RDWR | O_CREAT | O_APPEND, kAttempt);
        if (::flock(file.fd(), LOCK_EX | LOCK_NB) != 0) {
            if (errno == EWOULDBLOCK)
                fail(path, "another coordinator is writing to it");
            util::log_warn(
                "{} {}: it cannot be locked ({}), so see to it that no other coordinator writes to "
                "it",
                kAttempt, path.string(), std::strerror(errno));
        }
        if (util::is_named(file.fd(), file.path()))
            return file;
    }
}

/// Some file systems (network, FUSE) do not support this: that is no failure to write.
void flush_to_disk(const OpenFile& file) {
    if (::fdatasync(file.fd()) != 0 && errno != EINVAL && errno != ENOTSUP)
        fail(file.path(), std::strerror(errno));
}

/// Writes everything or, without space, nothing: a partial write is cut off again.
void write_all(const OpenFile& file, std::uint64_t end, std::span<const std::byte> head,
               std::span<const std::byte> payload) {
    for (const std::span<const std::byte> part : {head, payload})
        if (const int failed = util::write_all(file.fd(), part); failed != 0) {
            // If that fails as well, the next run cuts it off.
            if (::ftruncate(file.fd(), static_cast<off_t>(end)) != 0)
                util::log_debug("{} {}: a torn record stays", kAttempt, file.path().string());
            fail(file.path(), std::string(std::strerror(failed)) +
                                  "; the tiles in it are good, and --resume goes on with them");
        }
}

/// Writes the head of a new file and flushes it to the disk: without it no tile after it could be
/// read.
void begin(const OpenFile& file, const std::string& text) {
    try {
        write_all(file, 0, file_head(text), {});
        flush_to_disk(file);
    } catch (const util::Error&) {
        ::unlink(file.path().c_str());
        throw;
    }
}

}  // namespace

std::filesystem::path checkpoint_path(const std::filesystem::path& picture,
                                      const std::optional<Part>& part) {
    std::filesystem::path out = picture;
    if (part)
        out += ".part-" + std::to_string(part->index) + "-of-" + std::to_string(part->count);
    return out += ".tiles";
}

void check_can_checkpoint(const scene::Scene& scene) {
    if (scene.quality.time_s > 0)
        throw util::UsageError(
            "keep the tiles of an unfinished picture: quality.time_s is set, so that samples "
            "depend on the time; allowed: 0");
    if (scene.quality.coarse_step != 1)
        throw util::UsageError("keep the tiles of an unfinished picture: quality.coarse_step = " +
                               std::to_string(scene.quality.coarse_step) +
                               "; allowed: 1, a single pass");
}

Checkpoint::Checkpoint(std::filesystem::path path, const PictureKey& key, Existing existing)
    : m_path(std::move(path)) {
    util::check_writable(m_path);
    OpenFile file = locked(m_path);
    m_end = file.size();
    const bool is_new = m_end == 0;
    if (!is_new && existing == Existing::kRefuse)
        throw util::UsageError(
            kAttempt + " " + m_path.string() +
            ": it is there already; allowed: --resume, which goes on with it, or another name");
    const std::string text = key.to_json();
    if (is_new)
        begin(file, text);
    m_journal.emplace(std::move(file));
    // Compared in the form that a file gives back: names that are not UTF-8 change on the way.
    if (const std::string differs =
            difference(m_journal->key(), PictureKey::from_json(text, m_path.string()));
        !differs.empty())
        throw util::Error("go on with the checkpoint " + m_path.string() +
                          ": it is of another picture: " + differs + "; remove it to start again");
    m_empty = is_new;
    m_again.resize(key.grid.cells());
    for (std::uint32_t cell = 0; cell < m_again.size(); ++cell)
        if (m_journal->at(cell).holes > 0) {
            m_again[cell] = true;
            ++m_with_holes;
        }
    if (const std::string damaged = m_journal->what_is_damaged(); !damaged.empty())
        util::log_warn("{}; what is lost is rendered again", damaged);
    m_end = m_journal->end();
    if (::ftruncate(m_journal->file().fd(), static_cast<off_t>(m_end)) != 0)
        fail(m_path, std::strerror(errno));
}

Checkpoint::~Checkpoint() {
    if (!m_open || !m_journal)
        return;
    if (m_empty)
        ::unlink(m_path.c_str());
    else if (m_dirty)
        // No error can be reported here any more; the system writes what it has.
        ::fdatasync(m_journal->file().fd());
}

void Checkpoint::each(const std::function<void(tiles::TileResult&&)>& take) {
    for (std::uint32_t cell = 0; cell < m_again.size(); ++cell) {
        if (!m_journal->at(cell).is_there() || m_again[cell])
            continue;
        std::optional<tiles::TileResult> tile;
        try {
            tile = m_journal->tile(cell);
        } catch (const util::Error& e) {
            util::log_warn("{}; it is rendered again", e.what());
            m_journal->note({RecordKind::kForgotten, cell}, 0);
            continue;
        }
        take(std::move(*tile));
    }
}

bool Checkpoint::has(const tiles::RenderTile& tile) const {
    const std::uint32_t cell = find_cell(tile);
    return m_journal->at(cell).is_there() && !m_again[cell];
}

std::uint32_t Checkpoint::find_cell(const tiles::RenderTile& tile) const {
    const auto cell = m_journal->key().grid.find_cell(tile);
    if (!cell)
        throw util::Error(kAttempt + " " + m_path.string() + ": the tile at (" +
                          std::to_string(tile.x0) + ", " + std::to_string(tile.y0) +
                          ") is no whole tile of a single pass in tiles of " +
                          std::to_string(m_journal->key().grid.tile_px) + " pixels");
    return *cell;
}

void Checkpoint::add(const tiles::TileResult& result) {
    add_encoded(tiles::encode_tile(result));
}

void Checkpoint::add_encoded(std::span<const std::byte> bytes) {
    const tiles::TileHead head = tiles::read_tile_head(bytes, "for " + m_path.string());
    const std::uint32_t cell = find_cell(head.tile);
    if (head.content.layers != m_journal->key().with_layers)
        fail(m_path, std::string("the tile ") + std::to_string(cell) +
                         (head.content.layers ? " has layers; the picture has none"
                                              : " lacks the picture's layers"));
    m_journal->note(append(RecordKind::kTile, cell, bytes), head.holes);
    // With or without holes, the tile is now the result of this run.
    if (m_again[cell]) {
        m_again[cell] = false;
        --m_with_holes;
    }
}

void Checkpoint::forget(const tiles::RenderTile& tile) {
    const std::uint32_t cell = find_cell(tile);
    if (!m_journal->at(cell).is_there())
        return;
    m_journal->note(append(RecordKind::kForgotten, cell, {}), 0);
    if (m_again[cell]) {
        m_again[cell] = false;
        --m_with_holes;
    }
}

void Checkpoint::note_damage(const std::vector<std::string>& lines) {
    std::string fresh;
    for (std::string line : lines) {
        std::replace(line.begin(), line.end(), '\n', ' ');
        if (!line.empty() && !m_journal->damage().contains(line))
            fresh += line + "\n";
    }
    if (fresh.empty())
        return;
    (void)append(RecordKind::kDamage, 0, std::as_bytes(std::span(fresh)));
    m_journal->note_damage(fresh);
}

Record Checkpoint::append(RecordKind kind, std::uint32_t cell, std::span<const std::byte> payload) {
    if (!m_open)
        fail(m_path, "a tile came after the end");
    const auto head = record_head(kind, cell, payload);
    write_all(m_journal->file(), m_end, head, payload);
    const Record record{kind, cell, m_end + head.size(),
                        static_cast<std::uint32_t>(payload.size())};
    m_end += head.size() + payload.size();
    m_dirty = true;
    m_empty = false;
    if (std::chrono::steady_clock::now() - m_flushed >= kFlushPeriod)
        flush();
    return record;
}

void Checkpoint::flush() {
    if (m_dirty)
        flush_to_disk(m_journal->file());
    m_dirty = false;
    m_flushed = std::chrono::steady_clock::now();
}

void Checkpoint::finish() {
    m_open = false;
    if (::unlink(m_path.c_str()) != 0 && errno != ENOENT)
        throw util::Error("remove the checkpoint " + m_path.string() + ": " + std::strerror(errno));
}

void Checkpoint::close() {
    flush();
    m_open = false;
}

}  // namespace terravox::farm
