#include "raytracer/farm/checkpoint/tile_journal.hpp"

#include <algorithm>
#include <sstream>

#include "common/util/error.hpp"
#include "raytracer/core/tiles/tile_codec.hpp"

namespace terravox::farm {

TileJournal::TileJournal(OpenFile file) : m_file(std::move(file)) {
    const auto prepare = [this](const std::string& text) {
        if (!m_entries.empty())
            return;
        m_key = PictureKey::from_json(text, m_file.path().string());
        m_entries.resize(m_key.grid.cells());
    };
    const RecordScan scan = scan_records(m_file, [&](const std::string& text, const Record& record,
                                                     std::span<const std::byte> payload) {
        prepare(text);
        return take(record, payload);
    });
    prepare(scan.text);
    for (const Record& record : scan.damaged)
        m_damaged.insert(record.cell);
    m_lost_bytes = scan.lost_bytes;
    m_end = scan.end;
}

bool TileJournal::take(const Record& record, std::span<const std::byte> payload) {
    if (record.kind == RecordKind::kDamage) {
        note_damage({reinterpret_cast<const char*>(payload.data()), payload.size()});
        return true;
    }
    if (record.cell >= m_entries.size())
        return false;
    if (record.kind == RecordKind::kForgotten) {
        note(record, 0);
        return true;
    }
    if (record.kind != RecordKind::kTile)
        return false;
    try {
        const tiles::TileHead head = tiles::read_tile_head(payload, m_file.path().string());
        if (m_key.grid.cell_of(head.tile) != record.cell ||
            head.content.layers != m_key.with_layers)
            return false;
        note(record, head.holes);
    } catch (const util::Error&) {
        return false;  // reported as damage, with all the others
    }
    return true;
}

void TileJournal::note(const Record& record, std::uint32_t holes) {
    Entry& entry = m_entries.at(record.cell);
    m_count -= entry.is_there() ? 1 : 0;
    entry = record.kind == RecordKind::kTile ? Entry{record.offset, record.bytes, holes} : Entry{};
    m_count += entry.is_there() ? 1 : 0;
}

void TileJournal::note_damage(const std::string& lines) {
    std::istringstream in(lines);
    for (std::string line; std::getline(in, line);)
        if (!line.empty())
            m_damage.insert(line);
}

std::vector<std::byte> TileJournal::encoded(std::uint32_t cell) const {
    const Entry& entry = at(cell);
    std::vector<std::byte> bytes(entry.bytes);
    m_file.read(entry.offset, bytes);
    return bytes;
}

tiles::TileResult TileJournal::tile(std::uint32_t cell) const {
    return tiles::decode_tile(encoded(cell),
                              std::to_string(cell) + " of " + m_file.path().string());
}

std::string TileJournal::what_is_damaged() const {
    const auto tiles =
        std::count_if(m_damaged.begin(), m_damaged.end(), [this](std::uint32_t cell) {
            return cell >= m_entries.size() || !m_entries[cell].is_there();
        });
    std::string out;
    if (tiles > 0)
        out = std::to_string(tiles) + (tiles == 1 ? " tile" : " tiles");
    if (m_lost_bytes > 0)
        out += (out.empty() ? "" : ", and ") + std::to_string(m_lost_bytes) +
               " bytes that cannot be interpreted";
    return out.empty() ? out : m_file.path().string() + " is damaged: " + out;
}

}  // namespace terravox::farm
