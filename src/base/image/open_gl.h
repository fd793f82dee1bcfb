#pragma once

#include <cstdint>

struct osmesa_context;

// Types and constants of OpenGL 1.1 and OSMesa 22, as defined in their specifications. Debian's
// headers are not used, since they depend on 47 packages.
using GLenum = std::uint32_t;
using GLbitfield = std::uint32_t;
using GLboolean = std::uint8_t;
using GLint = std::int32_t;
using GLsizei = std::int32_t;
using GLfloat = float;
using GLdouble = double;

inline constexpr GLboolean GL_FALSE = 0;
inline constexpr GLboolean GL_TRUE = 1;
inline constexpr GLenum GL_POINTS = 0x0000;
inline constexpr GLenum GL_LINE_STRIP = 0x0003;
inline constexpr GLenum GL_TRIANGLES = 0x0004;
inline constexpr GLenum GL_SRC_ALPHA = 0x0302;
inline constexpr GLenum GL_ONE_MINUS_SRC_ALPHA = 0x0303;
inline constexpr GLenum GL_DEPTH_TEST = 0x0B71;
inline constexpr GLenum GL_BLEND = 0x0BE2;
inline constexpr GLenum GL_UNSIGNED_BYTE = 0x1401;
inline constexpr GLenum GL_MODELVIEW = 0x1700;
inline constexpr GLenum GL_PROJECTION = 0x1701;
inline constexpr GLbitfield GL_DEPTH_BUFFER_BIT = 0x00000100;
inline constexpr GLbitfield GL_COLOR_BUFFER_BIT = 0x00004000;
inline constexpr GLenum OSMESA_RGBA = 0x1908;

namespace rangegrasp::image {

/// The functions of OpenGL and OSMesa in use, named without the prefixes gl and OSMesa.
struct OpenGl {
  void (*begin)(GLenum mode);
  void (*blend_func)(GLenum source, GLenum destination);
  void (*clear)(GLbitfield mask);
  void (*clear_color)(GLfloat red, GLfloat green, GLfloat blue, GLfloat alpha);
  void (*color4f)(GLfloat red, GLfloat green, GLfloat blue, GLfloat alpha);
  void (*color4fv)(const GLfloat* color);
  void (*depth_mask)(GLboolean flag);
  void (*enable)(GLenum capability);
  void (*end)();
  void (*finish)();
  void (*line_width)(GLfloat width);
  void (*load_matrixd)(const GLdouble* matrix);
  void (*matrix_mode)(GLenum mode);
  void (*point_size)(GLfloat size);
  void (*scissor)(GLint x, GLint y, GLsizei width, GLsizei height);
  void (*vertex3dv)(const GLdouble* vertex);
  void (*viewport)(GLint x, GLint y, GLsizei width, GLsizei height);
  osmesa_context* (*create_context)(GLenum format, GLint depth_bits, GLint stencil_bits,
                                    GLint accumulation_bits, osmesa_context* shared);
  void (*destroy_context)(osmesa_context* context);
  GLboolean (*make_current)(osmesa_context* context, void* buffer, GLenum type, GLsizei width,
                            GLsizei height);
  osmesa_context* (*get_current_context)();
};

/// The functions of Mesa's library, which the first call loads: most runs draw nothing, and the
/// library depends on a compiler of 130 MB. @throws base::NotInstalled if the library is missing.
const OpenGl& Gl();

}  // namespace rangegrasp::image
