#include "mlic_core/io/pictures/png_image.h"

namespace mlic {
namespace {

void AppendBigEndian(std::uint32_t value, std::string* out) {
  for (int shift = 24; shift >= 0; shift -= 8) out->push_back(static_cast<char>((value >> shift) & 0xff));
}

std::uint32_t Crc32(const std::string& bytes) {
  std::uint32_t crc = 0xffffffffu;
  for (const char byte : bytes) {
    crc ^= static_cast<std::uint8_t>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1u) != 0 ? 0xedb88320u : 0u);
  }
  return ~crc;
}

std::uint32_t Adler32(const std::string& bytes) {
  std::uint32_t a = 1, b = 0;
  for (const char byte : bytes) {
    a = (a + static_cast<std::uint8_t>(byte)) % 65521u;
    b = (b + a) % 65521u;
  }
  return (b << 16) | a;
}

void AppendChunk(const std::string& type, const std::string& data, std::string* out) {
  AppendBigEndian(static_cast<std::uint32_t>(data.size()), out);
  *out += type + data;
  AppendBigEndian(Crc32(type + data), out);
}

// Bits of a deflate stream, least significant first.
class BitWriter {
 public:
  void Bits(std::uint32_t value, int count) {
    for (int i = 0; i < count; ++i) Bit((value >> i) & 1u);
  }
  // Huffman codes go most significant bit first.
  void Code(std::uint32_t code, int count) {
    for (int i = count - 1; i >= 0; --i) Bit((code >> i) & 1u);
  }
  std::string Finish() {
    while (used_ != 0) Bit(0);
    return bytes_;
  }

 private:
  void Bit(std::uint32_t bit) {
    current_ = static_cast<std::uint8_t>(current_ | (bit << used_));
    if (++used_ < 8) return;
    bytes_.push_back(static_cast<char>(current_));
    current_ = 0;
    used_ = 0;
  }
  std::string bytes_;
  std::uint8_t current_ = 0;
  int used_ = 0;
};

// A literal or length symbol in the fixed code of RFC 1951, 3.2.6.
void WriteSymbol(int symbol, BitWriter* out) {
  if (symbol < 144) {
    out->Code(static_cast<std::uint32_t>(0x30 + symbol), 8);
  } else if (symbol < 256) {
    out->Code(static_cast<std::uint32_t>(0x190 + symbol - 144), 9);
  } else if (symbol < 280) {
    out->Code(static_cast<std::uint32_t>(symbol - 256), 7);
  } else {
    out->Code(static_cast<std::uint32_t>(0xc0 + symbol - 280), 8);
  }
}

// Repeats are only ever the byte before, in pieces of 258 (symbol 285) or 3 (symbol 257), distance 1 (code
// 0).
std::string Deflate(const std::string& bytes) {
  BitWriter out;
  out.Bits(1, 1);  // the last block
  out.Bits(1, 2);  // fixed Huffman codes
  std::size_t i = 0;
  while (i < bytes.size()) {
    WriteSymbol(static_cast<std::uint8_t>(bytes[i]), &out);
    std::size_t run = 1;
    while (i + run < bytes.size() && bytes[i + run] == bytes[i]) ++run;
    std::size_t left = run - 1;
    for (const std::size_t piece : {std::size_t{258}, std::size_t{3}}) {
      for (; left >= piece; left -= piece) {
        WriteSymbol(piece == 258 ? 285 : 257, &out);
        out.Code(0, 5);
      }
    }
    i += run - left;
  }
  WriteSymbol(256, &out);
  return out.Finish();
}

}  // namespace

std::string EncodePng(const PaletteImage& image) {
  std::string rows;
  for (int y = 0; y < image.height; ++y) {
    rows.push_back(0);  // no filter
    rows.append(
        reinterpret_cast<const char*>(image.pixels.data()) + static_cast<std::size_t>(y) * image.width,
        static_cast<std::size_t>(image.width));
  }
  std::string header, colors, data;
  AppendBigEndian(static_cast<std::uint32_t>(image.width), &header);
  AppendBigEndian(static_cast<std::uint32_t>(image.height), &header);
  header += std::string("\x08\x03\x00\x00\x00", 5);  // 8 bits, palette
  for (const auto& color : image.palette) {
    for (const std::uint8_t channel : color) colors.push_back(static_cast<char>(channel));
  }
  data = std::string("\x78\x01", 2) + Deflate(rows);
  AppendBigEndian(Adler32(rows), &data);
  std::string png("\x89PNG\r\n\x1a\n", 8);
  AppendChunk("IHDR", header, &png);
  AppendChunk("PLTE", colors, &png);
  AppendChunk("tRNS", std::string(1, '\0'), &png);
  AppendChunk("IDAT", data, &png);
  AppendChunk("IEND", "", &png);
  return png;
}

std::string EncodeBase64(const std::string& bytes) {
  static const char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t value = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      value = (value << 8) | (i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0u);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += i + k <= bytes.size() ? kDigits[(value >> (18 - 6 * k)) & 63u] : '=';
    }
  }
  return text;
}

}  // namespace mlic
